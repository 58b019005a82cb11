# One function per kind of target; warnings, sanitizers and ccache are set in this one place.
#   covey_library(core_pgo SOURCES a.cpp b.cpp DEPENDS core_graph ...)      static library; includes are from the source root
#   covey_process(dpgo SOURCES main.cpp node.cpp DEPENDS ...)               executable build/<preset>/bin/dpgo
#   covey_test(core_pgo SOURCES ... DEPENDS ... [LABELS system] [PRIVATE_NETWORK])   Catch2 executable; each TEST_CASE is a ctest,
#                                                                           with PRIVATE_NETWORK in a network namespace of its own
#   covey_bench(pgo SOURCES ... DEPENDS ...)                                Google Benchmark executable bin/bench_pgo
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")

set(COVEY_SANITIZE "" CACHE STRING "comma-separated sanitizers: address,undefined or thread")
option(COVEY_TIDY "run clang-tidy on every source as it is compiled" OFF)

# The sources are small beside the headers that they read: six at a time compile in half the time. So no two of a target may use one
# name for different things.
if(NOT DEFINED CMAKE_UNITY_BUILD)
  set(CMAKE_UNITY_BUILD ON)
endif()
set(CMAKE_UNITY_BUILD_BATCH_SIZE 6)

add_link_options(-fuse-ld=gold)  # binutils' faster linker

find_program(CCACHE ccache)
if(CCACHE)
  # Paths relative to the source tree, so that clones share what is cached; the rest is what ccache wants for precompiled headers.
  set(CMAKE_CXX_COMPILER_LAUNCHER env CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE})
  set(CMAKE_C_COMPILER_LAUNCHER ${CCACHE})
endif()

if(COVEY_SANITIZE)
  # GCC 12 miscompiles vptr checks of member-function subscriptions, and the others triple the compile time of Eigen code.
  set(CMAKE_CXX_FLAGS_DEBUG "-O1 -g1")
  set(covey_sanitize_flags -fsanitize=${COVEY_SANITIZE} -fno-omit-frame-pointer)
  if(COVEY_SANITIZE MATCHES undefined)
    list(APPEND covey_sanitize_flags -fno-sanitize=vptr,null,alignment,object-size -fno-sanitize-recover=undefined)
  endif()
  # Under a sanitizer GCC 12 takes std::regex's insides for uninitialised.
  add_compile_options(${covey_sanitize_flags} -Wno-maybe-uninitialized)
  # Under the address sanitizer Eigen would align its memory by hand, and free by hand what OpenGV's Eigen has from plain malloc.
  add_compile_definitions(EIGEN_MALLOC_ALREADY_ALIGNED=1)
  add_link_options(${covey_sanitize_flags})
endif()

# What most sources begin by reading is read once. A source includes what it uses all the same: clang-tidy (bin/covey_tools/lint) sees it
# without this.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(Catch2 2 REQUIRED)
set(covey_common_headers
  <Eigen/Core> <Eigen/Geometry> <Eigen/SparseCore> <algorithm> <chrono> <cmath> <cstdint> <filesystem> <fstream> <functional> <map> <memory>
  <optional> <random> <set> <string> <utility> <variant> <vector>)
function(covey_precompiled target)
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/${target}.cpp CONTENT "")
  add_library(${target} OBJECT ${CMAKE_BINARY_DIR}/${target}.cpp)
  target_link_libraries(${target} PRIVATE Eigen3::Eigen Catch2::Catch2)
  target_compile_options(${target} PRIVATE -fpch-preprocess)
  target_precompile_headers(${target} PRIVATE ${ARGN})
endfunction()
covey_precompiled(common_headers ${covey_common_headers})
covey_precompiled(test_headers ${covey_common_headers} <catch2/catch.hpp>)

function(covey_target_settings target)
  cmake_parse_arguments(ARG "" "HEADERS" "" ${ARGN})
  if(NOT ARG_HEADERS)
    set(ARG_HEADERS common_headers)
  endif()
  target_precompile_headers(${target} REUSE_FROM ${ARG_HEADERS})
  target_compile_options(${target} PRIVATE -fpch-preprocess -Wall -Wextra -Werror -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual
    -Wno-subobject-linkage)  # GCC 12 takes a source that a unity source includes for a header
  target_include_directories(${target} PUBLIC ${CMAKE_SOURCE_DIR})
  if(COVEY_TIDY)
    set_target_properties(${target} PROPERTIES CXX_CLANG_TIDY "clang-tidy;--quiet")
  endif()
endfunction()

function(covey_library target)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_library(${target} STATIC ${ARG_SOURCES})
  target_link_libraries(${target} PUBLIC ${ARG_DEPENDS})
  covey_target_settings(${target})
endfunction()

function(covey_process target)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${target} ${ARG_SOURCES})
  target_link_libraries(${target} PRIVATE ${ARG_DEPENDS})
  covey_target_settings(${target})
endfunction()

function(covey_test name)
  cmake_parse_arguments(ARG "PRIVATE_NETWORK" "TIMEOUT" "SOURCES;DEPENDS;LABELS" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  if(ARG_LABELS)
    set(labels LABELS "${ARG_LABELS}")
  endif()
  set(target test_${name})
  add_executable(${target} ${ARG_SOURCES})
  target_link_libraries(${target} PRIVATE ${ARG_DEPENDS} Catch2::Catch2WithMain)
  target_compile_definitions(${target} PRIVATE COVEY_SOURCE_DIR="${CMAKE_SOURCE_DIR}" COVEY_BIN_DIR="${CMAKE_BINARY_DIR}/bin")
  covey_target_settings(${target} HEADERS test_headers)
  target_compile_options(${target} PRIVATE -Wno-array-bounds)  # GCC 12 sees overflows of Eigen's small matrices where there are none
  # Real time and sanitizers do not go together; built by name if one wants to try.
  if(COVEY_SANITIZE AND "${ARG_LABELS}" STREQUAL "system")
    set_target_properties(${target} PROPERTIES EXCLUDE_FROM_ALL TRUE)
  endif()
  if(ARG_PRIVATE_NETWORK)
    set_target_properties(${target} PROPERTIES
      CROSSCOMPILING_EMULATOR "${CMAKE_SOURCE_DIR}/bin/covey_tools/in_namespace;--require-private;--")
  endif()
  # -w NoTests: a test name that matches nothing must fail. A test that needs absent data prints "SKIPPED: reason".
  catch_discover_tests(${target} TEST_PREFIX "${name}: " EXTRA_ARGS -w NoTests
    PROPERTIES ${labels} TIMEOUT ${ARG_TIMEOUT}
    ENVIRONMENT "LSAN_OPTIONS=suppressions=${CMAKE_SOURCE_DIR}/tests/leaks.supp:print_suppressions=0" SKIP_REGULAR_EXPRESSION "SKIPPED: ")
endfunction()

function(covey_bench name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(bench_${name} ${ARG_SOURCES})
  target_link_libraries(bench_${name} PRIVATE ${ARG_DEPENDS} benchmark::benchmark_main)
  target_compile_definitions(bench_${name} PRIVATE COVEY_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
  covey_target_settings(bench_${name})
endfunction()
