# Embeds kernels/*.k in the library, in three readings: OpenCL C text, SPIR-V and C++. No file is looked for at
# run time. host/device/kernels.hpp declares one function for every kernel listed in boxunion_add_kernels.
include(CheckCXXCompilerFlag)
find_program(BOXUNION_GLSLANG glslangValidator)
find_program(BOXUNION_SPIRV_VAL spirv-val)
find_program(BOXUNION_CLANG NAMES clang clang-19 clang-18 clang-17 clang-16 clang-15 clang-14)
mark_as_advanced(BOXUNION_GLSLANG BOXUNION_SPIRV_VAL BOXUNION_CLANG)
if(NOT BOXUNION_GLSLANG)
  message(STATUS "boxunion: no glslangValidator: the kernels have no SPIR-V, the Vulkan back end is left out")
endif()
check_cxx_compiler_flag(-fno-tree-loop-distribute-patterns BOXUNION_NO_LOOP_CALLS)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64)$")
  check_cxx_compiler_flag(-march=x86-64-v3 BOXUNION_NATIVE_V3)
endif()

# The list of kernels.
function(boxunion_add_kernels target)
  boxunion_kernel(${target} contour)
  boxunion_kernel(${target} cell_faces)
  boxunion_kernel(${target} cell_occupancy)
  boxunion_kernel(${target} cell_occupancy_sums SOURCE cell_occupancy DEFINES SUMS)
  boxunion_kernel(${target} cell_boolean SOURCE cell_occupancy DEFINES BOOLEAN)
  boxunion_kernel(${target} cell_boolean_sums SOURCE cell_occupancy DEFINES BOOLEAN SUMS)
  boxunion_kernel(${target} copy)
endfunction()

# boxunion_kernel(target name [SOURCE stem] [DEFINES macro...]): kernels/<stem>.k, which declares KERNEL(<stem>), read
# with these macros, and known as <name>. The stem is the name unless given.
function(boxunion_kernel target name)
  cmake_parse_arguments(PARSE_ARGV 2 kernel "" "SOURCE" "DEFINES")
  if(NOT kernel_SOURCE)
    set(kernel_SOURCE ${name})
  endif()
  set(include_dir ${PROJECT_SOURCE_DIR}/kernels)
  set(text ${include_dir}/${kernel_SOURCE}.k)
  file(GLOB files CONFIGURE_DEPENDS ${include_dir}/*.h ${include_dir}/*/*.h)  # any of which it may include
  list(APPEND files ${text})
  set(out ${PROJECT_BINARY_DIR}/kernels/${name})
  list(TRANSFORM kernel_DEFINES PREPEND "-D" OUTPUT_VARIABLE kernel_options)

  # OpenCL: the text goes in with its headers; clang, if there is one, reads it in both shapes first
  set(checks)
  if(BOXUNION_CLANG)
    foreach(shape -UITEM -DITEM)
      list(APPEND checks COMMAND ${BOXUNION_CLANG} -x cl -cl-std=CL1.2 -target spir64
        -Xclang -finclude-default-header -fsyntax-only -Wall -Werror ${shape} ${kernel_options}
        -I${include_dir} ${text})
    endforeach()
  endif()
  set(embed ${PROJECT_SOURCE_DIR}/cmake/EmbedText.cmake)
  add_custom_command(OUTPUT ${out}.cl.inc DEPENDS ${files} ${embed} VERBATIM ${checks}
    COMMAND ${CMAKE_COMMAND} -DFILE=${kernel_SOURCE}.k -DINCLUDE_DIR=${include_dir} -DOUTPUT=${out}.cl.inc -P ${embed}
    COMMENT "Embedding kernel ${name} as OpenCL C")
  set(embedded ${out}.cl.inc)

  # Vulkan: one SPIR-V for each shape; the workgroup size is specialization constant 0
  if(BOXUNION_GLSLANG)
    configure_file(${PROJECT_SOURCE_DIR}/cmake/kernel.comp.in ${out}.comp @ONLY)
    foreach(shape group item)
      set(options -V --quiet --target-env vulkan1.2 -I${include_dir} ${kernel_options})
      if(shape STREQUAL "item")
        list(APPEND options -DITEM)
      endif()
      set(validate)
      if(BOXUNION_SPIRV_VAL)
        set(validate COMMAND ${BOXUNION_SPIRV_VAL} --target-env vulkan1.2 ${out}.${shape}.spv)
      endif()
      add_custom_command(OUTPUT ${out}.${shape}.spv.inc DEPENDS ${files} ${out}.comp VERBATIM
        COMMAND ${BOXUNION_GLSLANG} ${options} -o ${out}.${shape}.spv ${out}.comp ${validate}
        COMMAND ${BOXUNION_GLSLANG} ${options} --vn spirv_${shape} -o ${out}.${shape}.spv.inc ${out}.comp
        COMMENT "Embedding kernel ${name} as SPIR-V, shape ${shape}")
      list(APPEND embedded ${out}.${shape}.spv.inc)
    endforeach()
  endif()

  # C++: a file of its own for each instruction set, so the macros of one kernel never meet another's
  set(instruction_sets baseline)
  if(BOXUNION_NATIVE_V3)
    list(APPEND instruction_sets v3)
  endif()
  foreach(instruction_set IN LISTS instruction_sets)
    configure_file(${PROJECT_SOURCE_DIR}/cmake/kernel_native.cpp.in ${out}_${instruction_set}.cpp @ONLY)
    set(options -O3)
    if(BOXUNION_NO_LOOP_CALLS)
      list(APPEND options -fno-tree-loop-distribute-patterns)  # no calls of memset for a handful of words
    endif()
    if(instruction_set STREQUAL "v3")
      list(APPEND options -march=x86-64-v3)
    endif()
    set_source_files_properties(${out}_${instruction_set}.cpp TARGET_DIRECTORY ${target} PROPERTIES
      SKIP_PRECOMPILE_HEADERS ON
      COMPILE_OPTIONS "${options}" COMPILE_DEFINITIONS "${kernel_DEFINES}" INCLUDE_DIRECTORIES ${include_dir} OBJECT_DEPENDS "${files}")
    target_sources(${target} PRIVATE ${out}_${instruction_set}.cpp)
  endforeach()

  list(JOIN kernel_options " " kernel_options)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/kernel.cpp.in ${out}.cpp @ONLY)
  set_source_files_properties(${out}.cpp TARGET_DIRECTORY ${target} PROPERTIES OBJECT_DEPENDS "${embedded}")
  target_sources(${target} PRIVATE ${out}.cpp ${embedded})
endfunction()
