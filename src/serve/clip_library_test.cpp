#include <string>

#include <gtest/gtest.h>

#include <earpoint/error.h>
#include <earpoint/serve/clip_library.h>

namespace earpoint {
namespace {

ServedClip named(const std::string& name) {
  ServedClip clip;
  clip.name = name;
  clip.sound = Waveform(2, 16000, 16000);
  return clip;
}

TEST(ClipLibrary, OpensAClipOnceForAllWhoAsk) {
  ClipLibrary library;
  int opened = 0;
  library.add("a", "first", [&] {
    ++opened;
    return named("first");
  });
  const auto clip = library.open("a");
  ASSERT_NE(clip, nullptr);
  EXPECT_EQ(clip, library.open("a"));
  EXPECT_EQ(opened, 1);
  EXPECT_EQ(library.open("b"), nullptr);
}

TEST(ClipLibrary, HandsOnWhatAnOpenerComplainsOf) {
  ClipLibrary library;
  library.add("a", "bad", []() -> ServedClip { throw InputError("speech.wav", "is missing"); });
  EXPECT_THROW(static_cast<void>(library.open("a")), InputError);
  EXPECT_THROW(static_cast<void>(library.open("a")), InputError);
}

TEST(ClipLibrary, ListsNoPrivateClipsAndForgetsTheOldest) {
  ClipLibrary library;
  library.add("a", "first", [] { return named("first"); });
  const std::string oldest = library.add_private(named("mine"));
  EXPECT_EQ(oldest.size(), 32U);
  ASSERT_EQ(library.list().size(), 1U);
  EXPECT_NE(library.open(oldest), nullptr);
  for (int i = 0; i < 4; ++i) EXPECT_NE(library.open(library.add_private(named("other"))), nullptr);
  EXPECT_EQ(library.open(oldest), nullptr);
}

}  // namespace
}  // namespace earpoint
