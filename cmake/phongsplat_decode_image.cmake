# SPDX-License-Identifier: MIT
# phongsplat_decode_image: how samples, viewer, benchmarks and tests decode images (stb), compiled once for all of them.
if(NOT TARGET phongsplat_decode_image)
  find_path(STB_INCLUDE_DIR stb/stb_image.h)
  add_library(phongsplat_decode_image STATIC ${PROJECT_SOURCE_DIR}/samples/decode_image.c)
  phongsplat_target(phongsplat_decode_image)
  target_include_directories(phongsplat_decode_image PUBLIC ${PROJECT_SOURCE_DIR}/samples)
  target_include_directories(phongsplat_decode_image SYSTEM PRIVATE ${STB_INCLUDE_DIR})
  target_link_libraries(phongsplat_decode_image PUBLIC phongsplat)
endif()
