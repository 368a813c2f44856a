# Debian 12 packages; script/bootstrap names each of them.

find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(spdlog REQUIRED)
find_package(TBB REQUIRED)
find_package(tl-expected REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(CLI11 REQUIRED)
find_package(pugixml REQUIRED)
find_package(PNG REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(EPOXY REQUIRED IMPORTED_TARGET epoxy egl)
pkg_check_modules(XXHASH REQUIRED IMPORTED_TARGET libxxhash)

# CGAL sets build types and flags of its own accord unless told not to.
set(CGAL_DO_NOT_WARN_ABOUT_CMAKE_BUILD_TYPE ON)
find_package(CGAL 5.5 REQUIRED)

# Reads GLB, FBX and the rest; linked by ecorche-worker only.
find_package(assimp 5.2 REQUIRED)

find_path(CHOLMOD_INCLUDE cholmod.h PATH_SUFFIXES suitesparse REQUIRED)
find_library(CHOLMOD_LIBRARY cholmod REQUIRED)
find_library(OPENBLAS_LIBRARY NAMES openblas PATH_SUFFIXES openblas-pthread REQUIRED)
find_path(OPENBLAS_INCLUDE cblas.h
          PATHS /usr/include/x86_64-linux-gnu /usr/include/aarch64-linux-gnu /usr/include
          PATH_SUFFIXES openblas-pthread REQUIRED NO_DEFAULT_PATH)
add_library(ecorche_cholmod INTERFACE)
target_include_directories(ecorche_cholmod SYSTEM INTERFACE ${CHOLMOD_INCLUDE} ${OPENBLAS_INCLUDE})
target_link_libraries(ecorche_cholmod INTERFACE ${CHOLMOD_LIBRARY} ${OPENBLAS_LIBRARY})
add_library(ecorche::cholmod ALIAS ecorche_cholmod)

if(ECORCHE_STUDIO)
  find_package(Qt6 6.4 REQUIRED COMPONENTS Widgets OpenGL OpenGLWidgets)
endif()

if(ECORCHE_TESTS)
  find_package(Catch2 2.13 REQUIRED)
  find_package(rapidcheck REQUIRED)
  include(Catch)
endif()

find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE})
endif()
find_program(MOLD mold)
if(MOLD)
  add_link_options(-fuse-ld=mold)
endif()
