# SPDX-License-Identifier: MIT
# phongsplat_embed(PREFIX HEADER FILES OUT): turns every GLSL file into a C source in the build tree that defines the array
# PREFIX_<name>; see shaders/embed.cmake. OUT receives the sources, which include HEADER, where the arrays are declared.
function(phongsplat_embed prefix header files out)
  set(embed ${PROJECT_SOURCE_DIR}/shaders/embed.cmake)
  set(generated)
  foreach(shader ${files})
    get_filename_component(name ${shader} NAME)
    string(REPLACE "." "_" symbol ${name})
    set(output ${CMAKE_CURRENT_BINARY_DIR}/${prefix}_${symbol}.c)
    add_custom_command(
      OUTPUT ${output}
      COMMAND ${CMAKE_COMMAND} -DINPUT=${shader} -DOUTPUT=${output} -DSYMBOL=${prefix}_${symbol} -DHEADER=${header} -P ${embed}
      DEPENDS ${shader} ${embed}
      VERBATIM)
    list(APPEND generated ${output})
  endforeach()
  set(${out} ${generated} PARENT_SCOPE)
endfunction()
