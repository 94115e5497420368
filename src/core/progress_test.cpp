#include <algorithm>
#include <cstdio>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/core/progress.h>

namespace earpoint {
namespace {

std::string written(std::FILE* stream) {
  std::string text(static_cast<std::size_t>(std::ftell(stream)), '\0');
  std::rewind(stream);
  EXPECT_EQ(std::fread(text.data(), 1, text.size(), stream), text.size());
  return text;
}

TEST(StreamProgress, WritesOnePlainLineForAShortJobInAFile) {
  std::FILE* stream = std::tmpfile();
  StreamProgress progress(stream, false);
  progress.begin("rendering", 10, "s");
  for (int i = 0; i < 10; ++i) progress.advance(1);
  progress.finish();
  const std::string text = written(stream);
  EXPECT_EQ(text.find('\r'), std::string::npos);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
  EXPECT_EQ(text.substr(0, 26), "rendering 100 %  10/10 s  ");
  std::fclose(stream);
}

TEST(StreamProgress, DrawsABarInPlaceOnATerminal) {
  std::FILE* stream = std::tmpfile();
  StreamProgress progress(stream, true);
  progress.begin("rendering", 4, "s");
  progress.finish();
  const std::string text = written(stream);
  EXPECT_NE(text.find("░"), std::string::npos);
  EXPECT_NE(text.find('\r'), std::string::npos);
  std::fclose(stream);
}

TEST(StreamProgress, WritesANoteOnALineOfItsOwnAndDrawsTheBarAgain) {
  std::FILE* stream = std::tmpfile();
  StreamProgress progress(stream, true);
  progress.begin("rendering", 4, "s");
  progress.note("the lamp is broken");
  progress.finish();
  const std::string text = written(stream);
  const std::size_t note = text.find("\r\033[Kthe lamp is broken\n");
  ASSERT_NE(note, std::string::npos) << text;
  EXPECT_LT(text.find("rendering"), note);
  EXPECT_NE(text.find("rendering", note), std::string::npos);
  std::fclose(stream);
}

TEST(FormatDuration, ReadsAsPeopleWrite) {
  EXPECT_EQ(format_duration(12.4), "12 s");
  EXPECT_EQ(format_duration(200), "3 min 20 s");
  EXPECT_EQ(format_duration(7500), "2 h 05 min");
}

}  // namespace
}  // namespace earpoint
