# CPack's settings for the Debian packages; ./dev package runs it:
#   cpack --config packaging/debian.cmake -B out/packages
# The program comes from build/package, a build with static modules; the library from build/package-library.
cmake_path(GET CMAKE_CURRENT_LIST_DIR PARENT_PATH source)
file(STRINGS ${source}/CMakeLists.txt project REGEX "^project\\(earpoint VERSION ")
string(REGEX MATCH "[0-9]+\\.[0-9]+\\.[0-9]+" version "${project}")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME earpoint)
set(CPACK_PACKAGE_VERSION ${version})
string(REGEX MATCH "^[0-9]+\\.[0-9]+" interface "${version}")  # as in the soname
set(library libearpoint${interface})
set(CPACK_PACKAGE_FILE_NAME earpoint-${version})
set(CPACK_CMAKE_GENERATOR Ninja)
set(CPACK_PACKAGE_DESCRIPTION "Novel-view acoustic synthesis")
set(CPACK_PACKAGE_VENDOR "Earpoint")
set(CPACK_PACKAGE_CONTACT "The maintainers of Earpoint <maintainers@earpoint.invalid>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/debian_documents.cmake)

# Of each build the components in the list of that name.
set(CPACK_COMPONENTS_STATIC program models)
set(CPACK_COMPONENTS_SHARED renderer_library renderer)
set(CPACK_COMPONENTS_ALL ${CPACK_COMPONENTS_STATIC} ${CPACK_COMPONENTS_SHARED})
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_INSTALL_CMAKE_PROJECTS
  "${source}/build/package;earpoint;static;/"
  "${source}/build/package-library;earpoint;shared;/")

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY ">=")
set(exactly "(= ${version}-1)")

# What the programs are linked with, dpkg-shlibdeps finds out.
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME earpoint)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION sound)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "earpoint-models ${exactly}")
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "hear a recorded moment from another place
Renders the binaural sound at another position and orientation of the head from
one camera's picture and its binaural sound (novel-view acoustic synthesis).
It also simulates rooms and data sets, and measures renderings.")

set(CPACK_DEBIAN_MODELS_PACKAGE_NAME earpoint-models)
set(CPACK_DEBIAN_MODELS_PACKAGE_SECTION sound)
set(CPACK_DEBIAN_MODELS_PACKAGE_ARCHITECTURE all)
set(CPACK_COMPONENT_MODELS_DESCRIPTION "networks of Earpoint, trained
Weight files for earpoint and libearpoint, which render with them.")

set(CPACK_DEBIAN_RENDERER_LIBRARY_PACKAGE_NAME ${library})
set(CPACK_DEBIAN_RENDERER_LIBRARY_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_RENDERER_LIBRARY_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_RENDERER_LIBRARY_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_LIST_DIR}/triggers)
set(CPACK_DEBIAN_RENDERER_LIBRARY_PACKAGE_DEPENDS "earpoint-models ${exactly}")
set(CPACK_COMPONENT_RENDERER_LIBRARY_DESCRIPTION "library of Earpoint: rendering of clips and live sound
Renders recorded binaural sound at another position, as whole clips or live,
for programs in C++ and C.")

set(CPACK_DEBIAN_RENDERER_PACKAGE_NAME libearpoint-dev)
set(CPACK_DEBIAN_RENDERER_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_RENDERER_PACKAGE_DEPENDS "${library} ${exactly}")
set(CPACK_COMPONENT_RENDERER_DESCRIPTION "library of Earpoint: headers
Headers, CMake package and pkg-config file of libearpoint, for C++20 and C99.")
