# What cmake --install puts where. The modules of src/ and lab/ are internal: programs link one library for each
# component of find_package(earpoint), with the headers of include/earpoint.
include(CMakePackageConfigHelpers)

pkg_check_modules(SNDFILE REQUIRED IMPORTED_TARGET sndfile>=1.1)
pkg_check_modules(SOXR REQUIRED IMPORTED_TARGET soxr)
pkg_check_modules(MYSOFA REQUIRED IMPORTED_TARGET libmysofa)
pkg_check_modules(LIBZIP REQUIRED IMPORTED_TARGET libzip)
find_package(hwy REQUIRED)

set(EARPOINT_PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/earpoint)

# earpoint_add_component(<name> OUTPUT <library> MODULES <module>... LIBRARIES <target>... [REQUIRES <component>...]
#                        [OBJECTS <generator expression>...] HEADERS <file>...)
#
# One library of all objects of the modules, static or shared by BUILD_SHARED_LIBS: earpoint::<name> for programs that
# find the package.
function(earpoint_add_component name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "OUTPUT" "MODULES;LIBRARIES;REQUIRES;OBJECTS;HEADERS")
  set(target earpoint_component_${name})
  foreach(module IN LISTS arg_MODULES)
    list(APPEND arg_OBJECTS $<TARGET_OBJECTS:earpoint_${module}>)
  endforeach()
  add_library(${target} ${arg_OBJECTS})
  list(TRANSFORM arg_REQUIRES PREPEND earpoint_component_)
  target_link_libraries(${target} PUBLIC ${arg_REQUIRES} PRIVATE ${arg_LIBRARIES})
  target_include_directories(${target} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(${target} INTERFACE cxx_std_20)
  # Before 1.0 a minor version may change what programs were compiled against.
  set_target_properties(${target} PROPERTIES LINKER_LANGUAGE CXX OUTPUT_NAME ${arg_OUTPUT} EXPORT_NAME ${name}
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  if(BUILD_SHARED_LIBS)
    target_link_options(${target} PRIVATE LINKER:--as-needed LINKER:--no-undefined)
  endif()
  if(EARPOINT_SANITIZE)
    target_link_options(${target} PUBLIC -fsanitize=${EARPOINT_SANITIZE})
  endif()
  # What programs run with is a component apart from what they are compiled with.
  install(TARGETS ${target} EXPORT earpoint-${name}
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${name}_library NAMELINK_COMPONENT ${name}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${name})
  install(EXPORT earpoint-${name} NAMESPACE earpoint:: DESTINATION ${EARPOINT_PACKAGE_DIR} COMPONENT ${name})
  list(TRANSFORM arg_HEADERS PREPEND ${PROJECT_SOURCE_DIR}/include/earpoint/)
  install(FILES ${arg_HEADERS} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/earpoint COMPONENT ${name})
endfunction()

earpoint_add_component(renderer OUTPUT earpoint
  MODULES core audio spatial plot weights kernels synthesis network rt60 gtf vigas vam render library c_api
  LIBRARIES fmt::fmt PkgConfig::SNDFILE PkgConfig::SOXR PkgConfig::MYSOFA PkgConfig::LIBZIP hwy::hwy dnnl gomp
            Threads::Threads stdc++ m  # the last two for programs in C that link a static library
  HEADERS error.h export.h image.h network.h pose.h renderer.h stream.h vector3.h waveform.h)
install(FILES ${PROJECT_BINARY_DIR}/include/earpoint/version.h ${PROJECT_SOURCE_DIR}/bindings/c/include/earpoint/earpoint.h
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/earpoint COMPONENT renderer)

find_package(embree 3 REQUIRED)
find_package(meshoptimizer REQUIRED)
earpoint_add_component(lab OUTPUT earpoint_lab REQUIRES renderer
  MODULES media scene trace lab_library
  # Of evaluation only the metrics of sounds: the rest needs data sets and networks.
  OBJECTS "$<FILTER:$<TARGET_OBJECTS:earpoint_evaluate>,INCLUDE,/metrics.cpp|/speech_metrics.cpp>"
  LIBRARIES embree meshoptimizer::meshoptimizer PkgConfig::ASSIMP PkgConfig::FFMPEG fmt::fmt Threads::Threads
  HEADERS metrics.h trace.h)
if(BUILD_SHARED_LIBS)
  # Symbols of lower modules that the renderer's shared library hides.
  target_link_libraries(earpoint_component_lab PRIVATE earpoint::lab_library)
  # A program that links this library alone finds the renderer's beside it.
  set_target_properties(earpoint_component_lab PROPERTIES INSTALL_RPATH $ORIGIN)
endif()

install(DIRECTORY ${PROJECT_SOURCE_DIR}/models/ DESTINATION ${CMAKE_INSTALL_DATADIR}/earpoint/models
  COMPONENT models FILES_MATCHING PATTERN "*.safetensors" PATTERN "*.md")
install(TARGETS earpoint COMPONENT program)
if(TARGET earpoint-train)
  install(TARGETS earpoint-train COMPONENT program)
endif()

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/package/earpointConfig.cmake.in
  ${PROJECT_BINARY_DIR}/earpointConfig.cmake INSTALL_DESTINATION ${EARPOINT_PACKAGE_DIR})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/earpointConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/earpointConfig.cmake ${PROJECT_BINARY_DIR}/earpointConfigVersion.cmake
  DESTINATION ${EARPOINT_PACKAGE_DIR} COMPONENT renderer)

# A shared library links what it needs; with a static one the program must link it.
if(NOT BUILD_SHARED_LIBS)
  set(EARPOINT_PC_REQUIRES "sndfile soxr libmysofa libzip libhwy fmt")
  set(EARPOINT_PC_LIBS " -ldnnl -lgomp -pthread -lstdc++ -lm")
endif()
file(RELATIVE_PATH EARPOINT_PC_PREFIX ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
configure_file(${PROJECT_SOURCE_DIR}/cmake/package/earpoint.pc.in ${PROJECT_BINARY_DIR}/earpoint.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/earpoint.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT renderer)
