# Writes a C++ file with the contents of the files in FOLDER (of none if it is not given). It defines page_bytes(), which
# HEADER (default: page_bytes.h) declares in the namespace NAMESPACE (default: earpoint).
# Usage: cmake [-DFOLDER=...] [-DHEADER=...] [-DNAMESPACE=...] -DOUTPUT=... -P EmbedFiles.cmake
if(NOT HEADER)
  set(HEADER page_bytes.h)
endif()
if(NOT NAMESPACE)
  set(NAMESPACE earpoint)
endif()
set(arrays "")
set(table "")
set(count 0)
if(FOLDER)
  file(GLOB files ${FOLDER}/*)
  foreach(file IN LISTS files)
    get_filename_component(name ${file} NAME)
    file(READ ${file} bytes HEX)
    string(REGEX REPLACE "(..)" "0x\\1," bytes "${bytes}")
    string(APPEND arrays "constexpr unsigned char kBytes${count}[] = {\n${bytes}};\n")
    string(APPEND table "    {\"${name}\", {reinterpret_cast<const char*>(kBytes${count}), sizeof(kBytes${count})}},\n")
    math(EXPR count "${count} + 1")
  endforeach()
endif()
file(WRITE ${OUTPUT} "// Written by cmake/EmbedFiles.cmake.
#include \"${HEADER}\"

#include <array>

namespace ${NAMESPACE} {
namespace {

${arrays}
}  // namespace

std::span<const PageBytes> page_bytes() {
  static const std::array<PageBytes, ${count}> files{{
${table}  }};
  return files;
}

}  // namespace ${NAMESPACE}
")
