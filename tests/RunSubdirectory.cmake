# cmake -DSOURCE=... -DWORK=... -DCOMPILER=... -P RunSubdirectory.cmake: configures a project that has boxunion as a subdirectory. It gets
# the library alone: no command, hence no CLI11, no tests, nothing to install.
file(REMOVE_RECURSE ${WORK})
file(WRITE ${WORK}/CMakeLists.txt "cmake_minimum_required(VERSION 3.25)
project(host LANGUAGES CXX)
add_subdirectory(${SOURCE} boxunion)
file(WRITE volume.cpp \"int main() {}\")
add_executable(volume volume.cpp)
target_link_libraries(volume PRIVATE boxunion::boxunion)
if(TARGET boxunion_command OR TARGET boxunion_tests)
  message(FATAL_ERROR \"a subproject builds the command or the tests\")
endif()
")
execute_process(COMMAND ${CMAKE_COMMAND} -S ${WORK} -B ${WORK}/build -G Ninja -DCMAKE_CXX_COMPILER=${COMPILER}
  -DCMAKE_DISABLE_FIND_PACKAGE_CLI11=ON OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} --install ${WORK}/build --prefix ${WORK}/prefix OUTPUT_VARIABLE out COMMAND_ERROR_IS_FATAL ANY)
if(EXISTS ${WORK}/prefix/include)
  message(FATAL_ERROR "a subproject installs its own files: ${out}")
endif()
