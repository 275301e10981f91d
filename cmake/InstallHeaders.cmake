# Runs at install time, with `source` and `include_dir` set: installs include/boxunion/boxunion.hpp and all of ours
# that it includes. Includes such as "core/boxes/box.hpp" become "boxunion/core/boxes/box.hpp", so that users need one include
# folder and may have a core/ of their own.
cmake_policy(VERSION 3.25)
function(boxunion_install_header name file)
  set(target ${include_dir}/boxunion/${name})
  if(target IN_LIST CMAKE_INSTALL_MANIFEST_FILES)
    return()
  endif()
  list(APPEND CMAKE_INSTALL_MANIFEST_FILES ${target})
  file(READ ${file} text)
  string(REGEX MATCHALL "#include \"(core|host|kernels)/[a-z0-9_/]+\\.h(pp)?\"" includes "${text}")
  string(REGEX REPLACE "#include \"(core|host|kernels)/" "#include \"boxunion/\\1/" text "${text}")
  message(STATUS "Installing: $ENV{DESTDIR}${target}")
  file(WRITE "$ENV{DESTDIR}${target}" "${text}")
  foreach(include IN LISTS includes)
    string(REGEX REPLACE "#include \"(.*)\"" "\\1" include "${include}")
    boxunion_install_header(${include} ${source}/${include})
  endforeach()
  set(CMAKE_INSTALL_MANIFEST_FILES ${CMAKE_INSTALL_MANIFEST_FILES} PARENT_SCOPE)
endfunction()

boxunion_install_header(boxunion.hpp ${source}/include/boxunion/boxunion.hpp)
