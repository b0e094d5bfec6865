# SPDX-License-Identifier: MIT
# Script: writes the text file INPUT as the zero-terminated C array SYMBOL into OUTPUT.
# Bytes, not a string literal: C11 promises only 4095 characters for one.
file(READ ${INPUT} bytes HEX)
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
string(REGEX REPLACE "((0x[0-9a-f][0-9a-f],)(0x[0-9a-f][0-9a-f],)(0x[0-9a-f][0-9a-f],)(0x[0-9a-f][0-9a-f],)(0x[0-9a-f][0-9a-f],)(0x[0-9a-f][0-9a-f],)(0x[0-9a-f][0-9a-f],)(0x[0-9a-f][0-9a-f],))" "\\1\n" bytes "${bytes}")
get_filename_component(name ${INPUT} NAME)
file(WRITE ${OUTPUT} "/* Made from ${name} by embed.cmake. */\n#include \"${HEADER}\"\n\nconst char ${SYMBOL}[] = {\n${bytes}0x00};\n")
