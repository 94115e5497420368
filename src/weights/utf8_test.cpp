#include "utf8.h"

#include <string>

#include <gtest/gtest.h>

namespace earpoint {
namespace {

TEST(Utf8, AcceptsTheFirstAndLastCharacterOfEachLength) {
  for (const char* text :
       {"", "a", "\x7F", "\xC2\x80", "\xDF\xBF", "\xE0\xA0\x80", "\xED\x9F\xBF", "\xEE\x80\x80",
        "\xEF\xBF\xBF", "\xF0\x90\x80\x80", "\xF4\x8F\xBF\xBF"}) {
    EXPECT_TRUE(is_utf8(text)) << text;
  }
  EXPECT_TRUE(is_utf8(std::string("a\0b", 3)));
}

TEST(Utf8, RefusesStrayMissingOverlongAndForbidden) {
  for (const char* text :
       {"\x80", "\xC2", "\xC2\x61", "\xC1\xBF", "\xE0\x9F\xBF", "\xE1\x80", "\xED\xA0\x80",
        "\xF0\x8F\xBF\xBF", "\xF4\x90\x80\x80", "\xF5\x80\x80\x80", "\xFF", "\x61\xE1\x80\x61"}) {
    EXPECT_FALSE(is_utf8(text));
  }
}

}  // namespace
}  // namespace earpoint
