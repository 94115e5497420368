# Writes a C++ file that holds the files of FOLDER (none if it is not given) as page_bytes.h declares.
# Usage: cmake [-DFOLDER=...] -DOUTPUT=... -P EmbedFiles.cmake
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
#include \"page_bytes.h\"

#include <array>

namespace earpoint {
namespace {

${arrays}
}  // namespace

std::span<const PageBytes> page_bytes() {
  static const std::array<PageBytes, ${count}> files{{
${table}  }};
  return files;
}

}  // namespace earpoint
")
