# SPDX-License-Identifier: Apache-2.0
# cmake -DSOURCE_DIR=... -P layering.cmake: fails on an include against the arrows, or on a library
# outside its fence.

# may_include(FOLDER ALLOWED...): what a folder's files may include of ours.
set(rules
  "common/base=common/base"
  "common/optics=common/base|common/optics"
  "common/geometry=common/base|common/geometry"
  "common/image=common/base|common/image"
  "common/scene=common/base|common/optics|common/geometry|common/image|common/scene"
  "common/cloud=common/base|common/optics|common/geometry|common/image|common/scene|common/cloud"
  "common/nbody=common/base|common/optics|common/cloud|common/nbody"
  "common/diffusion=common/base|common/optics|common/cloud|common/nbody|common/diffusion"
  "common/exitance=common/base|common/optics|common/scene|common/cloud|common/nbody|common/diffusion|common/exitance"
  "common/lighting=common/base|common/optics|common/geometry|common/scene|common/diffusion|common/exitance|common/lighting"
  "precompute=common|precompute"
  "render=common|render"
  "material=common|precompute|render|material"
  "viewer=common|precompute|render|viewer"
  "experiments/reference=common|experiments/reference")

# LIBRARY HEADER PATTERN=FILES THAT MAY INCLUDE IT
set(fences
  "embree3/=(common/geometry/ray_scene|experiments/reference/mesh_body).cpp"
  "CGAL/=common/geometry/mesh_[a-z]+\\.cpp"
  "OpenMesh/=common/geometry/[a-z_]+\\.cpp"
  "(Imf|Imath|OpenEXR/)=common/image/exr_io.cpp"
  "png\\.h=common/image/png_(io|reader).cpp"
  "yaml-cpp/=common/scene/yaml_[a-z]+\\.(h|cpp)"
  "tbb/=common/base/(parallel|stats).cpp"
  "CLI/=common/base/cli.cpp"
  "nlohmann/=(common/base/stats|material/material_json).cpp"
  "(unsupported/)?Eigen/=common/diffusion/boundary_operator.cpp"
  "hwy/=(common/(nbody|diffusion)/([a-z_]+-inl\\.h|group_sum\\.cpp|boundary_sum\\.cpp|once_sum\\.cpp)|render/(beam|patch)_gate\\.cpp)"
  "SDL=viewer/(window|sdl_input|text_painter)\\.(h|cpp)")

set(errors "")
file(GLOB_RECURSE files RELATIVE ${SOURCE_DIR}
  ${SOURCE_DIR}/common/*.h ${SOURCE_DIR}/common/*.cpp ${SOURCE_DIR}/precompute/*.h
  ${SOURCE_DIR}/precompute/*.cpp ${SOURCE_DIR}/render/*.h ${SOURCE_DIR}/render/*.cpp
  ${SOURCE_DIR}/material/*.h ${SOURCE_DIR}/material/*.cpp
  ${SOURCE_DIR}/viewer/*.h ${SOURCE_DIR}/viewer/*.cpp
  ${SOURCE_DIR}/experiments/reference/*.h ${SOURCE_DIR}/experiments/reference/*.cpp)
if(NOT files)
  message(FATAL_ERROR "no sources under ${SOURCE_DIR}")
endif()
foreach(file IN LISTS files)
  file(STRINGS ${SOURCE_DIR}/${file} includes REGEX "^#include")
  foreach(line IN LISTS includes)
    string(REGEX REPLACE "^#include [<\"]([^>\"]+)[>\"].*" "\\1" header "${line}")
    foreach(rule IN LISTS rules)
      string(REGEX MATCH "^([^=]+)=(.*)$" _ "${rule}")
      set(folder "${CMAKE_MATCH_1}")
      set(allowed "${CMAKE_MATCH_2}")
      if(file MATCHES "^${folder}/"
          AND header MATCHES "^(common|precompute|render|material|viewer|experiments)/"
          AND NOT header MATCHES "^(${allowed})/")
        list(APPEND errors "${file} includes ${header}: a wrong arrow")
      endif()
    endforeach()
    foreach(fence IN LISTS fences)
      string(REGEX MATCH "^([^=]+)=(.*)$" _ "${fence}")
      set(library "${CMAKE_MATCH_1}")
      set(inside "${CMAKE_MATCH_2}")
      if(header MATCHES "^${library}" AND NOT file MATCHES "^${inside}$")
        list(APPEND errors "${file} includes ${header}: outside its fence")
      endif()
    endforeach()
  endforeach()
endforeach()
if(errors)
  list(JOIN errors "\n  " text)
  message(FATAL_ERROR "\n  ${text}")
endif()
list(LENGTH files count)
message(STATUS "layering: ${count} files keep the arrows and the fences")
