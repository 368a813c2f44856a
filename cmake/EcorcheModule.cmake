# One static library per room of the house, with our warnings and the sanitizers that a preset asks for.

add_library(ecorche_options INTERFACE)
target_include_directories(ecorche_options INTERFACE ${PROJECT_SOURCE_DIR}/src)
target_compile_options(ecorche_options INTERFACE -Wall -Wextra -Wshadow=local -Wno-psabi -Wno-restrict
                       -Wno-missing-field-initializers)
# Symbols for profiles cost nothing at run time; line tables alone keep the build small and quick.
target_compile_options(ecorche_options INTERFACE $<$<CONFIG:Release>:-g1>)
if(ECORCHE_SANITIZE)
  target_compile_options(ecorche_options INTERFACE -fsanitize=${ECORCHE_SANITIZE} -fno-omit-frame-pointer -O1)
  target_link_options(ecorche_options INTERFACE -fsanitize=${ECORCHE_SANITIZE})
endif()
if(ECORCHE_FUZZ)
  target_compile_options(ecorche_options INTERFACE -fsanitize=fuzzer-no-link,address,undefined
                         -fno-sanitize-recover=all -Wno-unknown-warning-option)
  target_link_options(ecorche_options INTERFACE -fsanitize=address,undefined)
endif()
if(ECORCHE_CHECKED)
  target_compile_definitions(ecorche_options INTERFACE ECORCHE_CHECKED=1)
endif()

# ecorche_compile_together(ecorche): what its files read in common is read and instantiated once for a dozen of them, which
# halves a whole build. Names in unnamed namespaces are one dozen's, then, not one file's. What a file does not include
# itself shows in presets that compile each alone (`fuzz`), or with ECORCHE_TOGETHER off.
function(ecorche_compile_together target)
  if(ECORCHE_TOGETHER AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # It takes names of included files for those of headers
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${ECORCHE_TOGETHER} UNITY_BUILD_BATCH_SIZE 12)
endfunction()

# ecorche_add_module(mesh SOURCES ... PUBLIC libs PRIVATE libs) makes ecorche::mesh.
#
# UNSANITIZED names sources that presets `dev` and `fuzz` compile without their sanitizers: those that instantiate CGAL's
# large algorithms, where both sanitizers together take five times as long and up to 4 GB each (uncross.cpp did not end
# within six minutes). What is lost: a wrong access or overflow in CGAL's code, or in ours within these files, goes
# unseen until it touches heap that someone else has freed or until instrumented code meets the result. Whether memory
# handed to them is freed once, and everything that they return, is still seen.
function(ecorche_add_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;UNSANITIZED;PUBLIC;PRIVATE" ${ARGN})
  set(target ecorche_${name})
  add_library(${target} STATIC ${ARG_SOURCES} ${ARG_UNSANITIZED})
  if((ECORCHE_SANITIZE OR ECORCHE_FUZZ) AND ARG_UNSANITIZED)
    # Eigen aligns by itself where g++ says that AddressSanitizer is at work; what one file takes others free.
    # -O2 because most of a domain's time is spent here, and nothing is left that -O1 would show better
    set(options -fno-sanitize=all -g1)
    if(ECORCHE_SANITIZE)
      list(APPEND options -O2)
    endif()
    if(ECORCHE_SANITIZE MATCHES address)
      list(APPEND options -DEIGEN_MALLOC_ALREADY_ALIGNED=0)
    endif()
    set_source_files_properties(${ARG_UNSANITIZED} PROPERTIES COMPILE_OPTIONS "${options}")
  endif()
  ecorche_compile_together(${target})
  add_library(ecorche::${name} ALIAS ${target})
  target_link_libraries(${target} PUBLIC ecorche_options ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
endfunction()

# Sanitizers take ten times as long [s].
set(ECORCHE_TEST_TIMEOUT 300)
if(ECORCHE_SANITIZE)
  set(ECORCHE_TEST_TIMEOUT 3600)
endif()

# Most of a test's time is spent in libraries: less is made better in the tests themselves, and they are there sooner.
function(ecorche_compile_as_test target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()

# ecorche_add_test(mesh SOURCES ... LIBS ...) makes the program test_mesh; each TEST_CASE is a test of ctest, run after
# what FIXTURES names has been set up; with SCREEN on a screen of its own, that nobody sees.
function(ecorche_add_test name)
  cmake_parse_arguments(ARG "SCREEN" "" "SOURCES;LIBS;FIXTURES" ${ARGN})
  set(target test_${name})
  add_executable(${target} ${ARG_SOURCES})
  ecorche_compile_together(${target})
  target_link_libraries(${target} PRIVATE ecorche_options ecorche_test_support ${ARG_LIBS})
  ecorche_compile_as_test(${target})
  set(properties TIMEOUT ${ECORCHE_TEST_TIMEOUT} ENVIRONMENT "OPENBLAS_NUM_THREADS=2")
  if(ARG_FIXTURES)
    list(APPEND properties FIXTURES_REQUIRED ${ARG_FIXTURES})
  endif()
  if(ARG_SCREEN)
    set_property(TARGET ${target} PROPERTY
      CROSSCOMPILING_EMULATOR "xvfb-run;--auto-servernum;--server-args=-screen 0 1440x900x24")
  endif()
  catch_discover_tests(${target} TEST_PREFIX "${name}: " PROPERTIES ${properties})
endfunction()
