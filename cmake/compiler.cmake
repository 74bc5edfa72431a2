# SPDX-License-Identifier: Apache-2.0
# tallow_options: what every target of ours is compiled with.
add_library(tallow_options INTERFACE)
target_compile_features(tallow_options INTERFACE cxx_std_20)
set(CMAKE_CXX_EXTENSIONS OFF)

# No -ffast-math: it deletes the NaN checks and the reproducibility. These two are safe.
# -ffp-contract=off: the same result on machines with and without fused multiply-add.
target_compile_options(tallow_options INTERFACE
  -fno-math-errno -fno-trapping-math -ffp-contract=off
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wimplicit-fallthrough
  -Wno-stringop-overflow  # g++ 12 reports fmt's own buffers (false positive at -O3)
  $<$<BOOL:${TALLOW_WERROR}>:-Werror>
  $<$<BOOL:${TALLOW_NATIVE}>:-march=native>)

foreach(sanitizer IN LISTS TALLOW_SANITIZE)
  target_compile_options(tallow_options INTERFACE -fsanitize=${sanitizer} -fno-omit-frame-pointer)
  target_link_options(tallow_options INTERFACE -fsanitize=${sanitizer})
endforeach()
if(TALLOW_SANITIZE)
  # g++ 12 sees uninitialised values in the standard library where a sanitizer instruments it.
  target_compile_options(tallow_options INTERFACE -Wno-maybe-uninitialized)
endif()
if("undefined" IN_LIST TALLOW_SANITIZE)
  target_compile_options(tallow_options INTERFACE -fno-sanitize-recover=undefined)
endif()

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()
