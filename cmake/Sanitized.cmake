# The library and the command once more, with address and undefined behaviour sanitizers, in sanitized/ of the build. The
# tests and fuzz targets that drive them are not sanitized themselves: they are compiled once, and run fast. The preset
# `asan` sanitizes all.
set(sanitized_folder ${PROJECT_BINARY_DIR}/sanitized)

# Makes `target` of what `original` is made of.
function(boxunion_sanitize target original)
  foreach(property SOURCES INCLUDE_DIRECTORIES COMPILE_DEFINITIONS LINK_LIBRARIES)
    get_target_property(values ${original} ${property})
    if(values)
      list(TRANSFORM values REPLACE "^boxunion$" boxunion_sanitized)
      set(${property} ${values})
    endif()
  endforeach()
  target_sources(${target} PRIVATE ${SOURCES})
  target_include_directories(${target} PUBLIC ${INCLUDE_DIRECTORIES})
  target_compile_definitions(${target} PRIVATE ${COMPILE_DEFINITIONS})
  target_link_libraries(${target} PUBLIC ${LINK_LIBRARIES})
  target_compile_options(${target} PRIVATE -fsanitize=address,undefined ${sanitizer_options} -O1 -g1)
  target_link_options(${target} PUBLIC -fsanitize=address,undefined)
endfunction()

add_library(boxunion_sanitized OBJECT EXCLUDE_FROM_ALL)
boxunion_sanitize(boxunion_sanitized boxunion)
target_precompile_headers(boxunion_sanitized PRIVATE ${precompiled_headers})

add_executable(boxunion_sanitized_command EXCLUDE_FROM_ALL tests/sanitizers.cpp)
boxunion_sanitize(boxunion_sanitized_command boxunion_command)
set_target_properties(boxunion_sanitized_command PROPERTIES OUTPUT_NAME boxunion RUNTIME_OUTPUT_DIRECTORY ${sanitized_folder})
