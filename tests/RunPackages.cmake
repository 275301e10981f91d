# cmake -DBUILD=... -DWORK=... -DCOMPILER=... -P RunPackages.cmake: makes the Debian packages of a build, unpacks them into an
# empty root and uses them there: the command, and a program that is linked with the library.
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

find_program(DPKG_DEB dpkg-deb)
find_program(DPKG_SHLIBDEPS dpkg-shlibdeps)
if(NOT DPKG_DEB OR NOT DPKG_SHLIBDEPS)
  message(STATUS "SKIPPED: dpkg-deb or dpkg-shlibdeps was not found")
  return()
endif()
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK}/packages ${WORK}/root)
execute_process(COMMAND ${CMAKE_CPACK_COMMAND} -G DEB -B ${WORK}/packages --config ${BUILD}/CPackConfig.cmake
  OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
file(GLOB packages ${WORK}/packages/*.deb)
list(LENGTH packages count)
if(NOT count EQUAL 3)
  message(FATAL_ERROR "found ${count} packages, expected the library, its headers and the command: ${packages}")
endif()
foreach(package IN LISTS packages)
  run(${DPKG_DEB} -x ${package} ${WORK}/root)
  execute_process(COMMAND ${DPKG_DEB} -f ${package} Package Depends OUTPUT_VARIABLE fields COMMAND_ERROR_IS_FATAL ANY)
  if(NOT fields MATCHES "libtbb|= ")
    message(FATAL_ERROR "${package} depends on too little: ${fields}")
  endif()
endforeach()

file(GLOB_RECURSE command ${WORK}/root/*/bin/boxunion)
file(GLOB_RECURSE library ${WORK}/root/*/libboxunion.so)
file(GLOB_RECURSE header ${WORK}/root/*/include/boxunion/boxunion.hpp)
file(GLOB_RECURSE pc ${WORK}/root/*/boxunion.pc)
cmake_path(GET library PARENT_PATH library_folder)
cmake_path(GET header PARENT_PATH include_folder)
cmake_path(GET include_folder PARENT_PATH include_folder)
cmake_path(GET pc PARENT_PATH pc_folder)

file(WRITE ${WORK}/boxes.csv "0,0,0,2,2,2\n1,1,1,3,3,3\n")
execute_process(COMMAND ${command} measure ${WORK}/boxes.csv --quiet OUTPUT_VARIABLE out COMMAND_ERROR_IS_FATAL ANY)
if(NOT out MATCHES "volume +15")
  message(FATAL_ERROR "the packaged command printed\n${out}")
endif()
file(WRITE ${WORK}/volume.cpp "#include <boxunion/boxunion.hpp>
#include <cstdio>
int main() {
  const boxunion::BoxSet boxes(std::vector<boxunion::Box>{{0, 0, 0, 2, 2, 2}, {1, 1, 1, 3, 3, 3}});
  std::printf(\"%g\", boxunion::measure(boxes).volume);
}
")
run(${COMPILER} -std=c++20 -I${include_folder} ${WORK}/volume.cpp -o ${WORK}/volume -L${library_folder} -lboxunion
  -Wl,-rpath,${library_folder})
execute_process(COMMAND ${WORK}/volume OUTPUT_VARIABLE out COMMAND_ERROR_IS_FATAL ANY)
if(NOT out STREQUAL "15")
  message(FATAL_ERROR "a program with the packaged library printed ${out}, expected 15")
endif()

find_program(PKG_CONFIG pkg-config)
if(PKG_CONFIG)
  set(ENV{PKG_CONFIG_PATH} ${pc_folder})
  execute_process(COMMAND ${PKG_CONFIG} --cflags --libs boxunion OUTPUT_VARIABLE flags
    OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(flags)
  run(${COMPILER} -std=c++20 ${WORK}/volume.cpp -o ${WORK}/volume_by_pkg_config ${flags})
endif()
