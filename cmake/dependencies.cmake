# SPDX-License-Identifier: Apache-2.0
# Each dependency is linked by the one folder that fences it in; docs/DEPENDENCIES.md says why.
find_package(glm REQUIRED)
find_package(fmt REQUIRED)
find_package(TBB REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(OpenEXR REQUIRED)
find_package(PNG REQUIRED)
find_package(embree 3.13 REQUIRED)
find_package(Boost REQUIRED)  # header-only parts, beside CGAL, which needs them too
find_package(CGAL REQUIRED)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(hwy REQUIRED)
find_package(OpenMesh REQUIRED CONFIG)  # CGAL ships a module of that name, for another layout
find_package(PkgConfig REQUIRED)
pkg_check_modules(xxhash REQUIRED IMPORTED_TARGET libxxhash)
if(TALLOW_BENCHMARKS)
  find_package(benchmark REQUIRED)
endif()
