# cmake -DBUILD=... -DSOURCE=... -DWORK=... -P RunConsumer.cmake: installs the build to a fresh prefix, configures and
# builds tests/consumer against it alone, and runs it. Also installs the way packagers do, under a DESTDIR.
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
run(${CMAKE_COMMAND} -S ${SOURCE}/tests/consumer -B ${WORK}/build -G Ninja -DCMAKE_BUILD_TYPE=Release
  -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_PREFIX_PATH=${WORK}/prefix
  "-DCMAKE_CXX_FLAGS=-Wall -Wextra -Werror")
run(${CMAKE_COMMAND} --build ${WORK}/build)
execute_process(COMMAND ${WORK}/build/volume OUTPUT_VARIABLE out COMMAND_ERROR_IS_FATAL ANY)
message("${out}")
if(NOT out MATCHES "^volume 15, area 42, 20 vertices by ")
  message(FATAL_ERROR "the consumer printed something else")
endif()
run(${WORK}/prefix/bin/boxunion --version)

set(ENV{DESTDIR} ${WORK}/stage)
run(${CMAKE_COMMAND} --install ${BUILD} --prefix /usr)
if(NOT EXISTS ${WORK}/stage/usr/include/boxunion/core/box.hpp)
  message(FATAL_ERROR "the headers are not under DESTDIR")
endif()
