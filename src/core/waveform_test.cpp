#include <stdexcept>

#include <gtest/gtest.h>

#include <earpoint/image.h>
#include <earpoint/waveform.h>

namespace earpoint {
namespace {

TEST(Waveform, ChannelsAreContiguousAndApart) {
  Waveform waveform(2, 3, 16000);
  waveform.channel(1)[0] = 5.0F;
  EXPECT_EQ(waveform.planar()[3], 5.0F);
  EXPECT_EQ(waveform.channel(0)[0], 0.0F);
  EXPECT_DOUBLE_EQ(waveform.duration_s(), 3.0 / 16000);
  EXPECT_THROW((void)waveform.channel(2), std::logic_error);
  EXPECT_THROW(Waveform(2, 3, 0), std::logic_error);
}

TEST(Image, PixelsAreInterleavedRowByRow) {
  Image image(4, 2, 3);
  image.at(1, 1, 2) = 9;
  EXPECT_EQ(image.pixels()[(1 * 4 + 1) * 3 + 2], 9);
}

}  // namespace
}  // namespace earpoint
