# SPDX-License-Identifier: MIT
# phongsplat_target(NAME): the language level, warnings and sanitizers that every target of ours shares.
function(phongsplat_target name)
  target_compile_features(${name} PRIVATE c_std_11)
  set_target_properties(${name} PROPERTIES C_EXTENSIONS OFF CXX_STANDARD 17 CXX_STANDARD_REQUIRED ON CXX_EXTENSIONS OFF
                                           POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${name} PRIVATE -Wall -Wextra -Wpedantic -Wconversion $<$<BOOL:${PHONGSPLAT_WERROR}>:-Werror>)
  if(PHONGSPLAT_SANITIZE)
    target_compile_options(${name} PRIVATE -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_link_options(${name} PRIVATE -fsanitize=address,undefined)
  endif()
  if(PHONGSPLAT_FUZZ)
    target_compile_options(${name} PRIVATE -fsanitize=fuzzer-no-link)
    target_link_options(${name} PRIVATE -fsanitize=fuzzer-no-link)
  endif()
endfunction()

# phongsplat_optimised(NAME): a library for which tests wait. With sanitizers its C, whose loops over coordinates are then unrolled,
# runs in two thirds of the time, which saves more than compiling it takes. C++ is mostly CGAL, which takes longest to compile.
function(phongsplat_optimised name)
  if(PHONGSPLAT_SANITIZE)
    target_compile_options(${name} PRIVATE $<$<COMPILE_LANGUAGE:C>:-O3>)
  endif()
endfunction()
