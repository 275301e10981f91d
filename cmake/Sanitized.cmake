# The library once more, with address and undefined behaviour sanitizers, and in sanitized/ of the build what drives it: the
# command and the tests. Those are the same objects as without sanitizers, so that they are compiled once and tests run
# fast. The preset `asan` sanitizes all.

add_library(boxunion_sanitized OBJECT EXCLUDE_FROM_ALL)
get_target_property(sanitized_sources boxunion_objects SOURCES)
target_sources(boxunion_sanitized PRIVATE ${sanitized_sources})
target_include_directories(boxunion_sanitized PUBLIC $<TARGET_PROPERTY:boxunion_objects,INCLUDE_DIRECTORIES>)
target_compile_definitions(boxunion_sanitized PRIVATE ${definitions})
target_link_libraries(boxunion_sanitized PUBLIC ${dependencies} PRIVATE Boost::headers nlohmann_json::nlohmann_json boxunion_warnings)
target_compile_options(boxunion_sanitized PRIVATE -fsanitize=address,undefined ${sanitizer_options} -O1 -g1)
target_link_options(boxunion_sanitized PUBLIC -fsanitize=address,undefined)
target_precompile_headers(boxunion_sanitized PRIVATE ${precompiled_headers})
boxunion_unite_sources(boxunion_sanitized)

# boxunion_sanitized_program(name program): `program` with the sanitized library. Of a function that both have, the linker
# takes the first one: the sanitized one.
function(boxunion_sanitized_program name program)
  add_executable(${name} EXCLUDE_FROM_ALL $<TARGET_OBJECTS:boxunion_sanitized> $<TARGET_OBJECTS:${program}> ${ARGN})
  get_target_property(libraries ${program} LINK_LIBRARIES)
  list(TRANSFORM libraries REPLACE "^boxunion_internal$" "${dependencies}")
  target_link_libraries(${name} PRIVATE ${libraries})
  target_link_options(${name} PRIVATE -fsanitize=address,undefined)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/sanitized)
endfunction()

boxunion_sanitized_program(boxunion_sanitized_command boxunion_command tests/support/sanitizers.cpp)
set_target_properties(boxunion_sanitized_command PROPERTIES OUTPUT_NAME boxunion)
