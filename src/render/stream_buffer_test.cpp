#include <gtest/gtest.h>

#include <earpoint/render/stream_buffer.h>

namespace earpoint {
namespace {

Waveform ramp(std::ptrdiff_t start, std::ptrdiff_t count) {
  Waveform block(2, count, 16000);
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    block.channel(0)[i] = static_cast<float>(start + i);
    block.channel(1)[i] = -static_cast<float>(start + i);
  }
  return block;
}

TEST(StreamBuffer, WindowsKeepTheirPlaceAfterDropping) {
  StreamBuffer buffer(2, 16000);
  buffer.append(ramp(0, 100));
  buffer.append(ramp(100, 50));
  buffer.drop_before(60);
  EXPECT_EQ(buffer.end(), 150);
  const Waveform window = buffer.copy(70, 10);
  EXPECT_EQ(window.channel(0)[0], 70.0F);
  EXPECT_EQ(window.channel(1)[9], -79.0F);
  EXPECT_THROW((void)buffer.copy(59, 10), std::logic_error);
}

TEST(StreamBuffer, OutsideTheStreamThereIsSilence) {
  StreamBuffer buffer(2, 16000);
  buffer.append(ramp(1, 10));
  const Waveform early = buffer.copy(-3, 5);
  EXPECT_EQ(early.channel(0)[2], 0.0F);
  EXPECT_EQ(early.channel(0)[3], 1.0F);
  const Waveform late = buffer.copy(8, 5);
  EXPECT_EQ(late.channel(0)[1], 10.0F);
  EXPECT_EQ(late.channel(0)[2], 0.0F);
  EXPECT_EQ(buffer.copy(-20, 5).channel(0)[4], 0.0F);
  EXPECT_EQ(buffer.copy(20, 5).channel(0)[0], 0.0F);
}

}  // namespace
}  // namespace earpoint
