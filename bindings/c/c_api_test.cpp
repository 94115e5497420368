#include "test_model.h"

#include <algorithm>
#include <string>
#include <thread>

#include <earpoint/core_testing/allocation_count.h>
#include <earpoint/earpoint.h>
#include <earpoint/image.h>
#include <earpoint/network.h>
#include <earpoint/pose.h>
#include <earpoint/renderer.h>
#include <earpoint/version.h>

namespace earpoint {
namespace {

// C's library gives the samples of the one for C++, bit for bit: both are one code.

bool same(const Waveform& a, const Waveform& b) {
  return std::ranges::equal(a.planar(), b.planar());
}

bool silent(const Waveform& sound) {
  return std::ranges::all_of(sound.planar(), [](float sample) { return sample == 0.0f; });
}

/// Closes when it goes out of scope.
struct OpenRenderer {
  explicit OpenRenderer(const char* model, const earpoint_renderer_options* options = nullptr) {
    EXPECT_EQ(earpoint_renderer_open(model, options, &handle), EARPOINT_OK)
        << earpoint_last_error();
  }
  ~OpenRenderer() { earpoint_renderer_close(handle); }
  OpenRenderer(const OpenRenderer&) = delete;
  OpenRenderer& operator=(const OpenRenderer&) = delete;

  earpoint_renderer* handle = nullptr;
};

struct OpenStream {
  OpenStream(const OpenRenderer& renderer, const earpoint_stream_options* options) {
    EXPECT_EQ(earpoint_stream_create(renderer.handle, options, &handle), EARPOINT_OK)
        << earpoint_last_error();
  }
  ~OpenStream() { earpoint_stream_destroy(handle); }
  OpenStream(const OpenStream&) = delete;
  OpenStream& operator=(const OpenStream&) = delete;

  earpoint_stream* handle = nullptr;
};

Waveform rendered(const char* model, const TestSound& sound, const earpoint_request* request,
                  const earpoint_renderer_options* options = nullptr) {
  const OpenRenderer renderer(model, options);
  TestEars ears(sound);
  EXPECT_EQ(earpoint_renderer_render(renderer.handle, &sound.sound, request, ears.out()),
            EARPOINT_OK)
      << earpoint_last_error();
  EXPECT_FALSE(silent(ears.waveform));
  return ears.waveform;
}

class CApi : public TestModel {};

TEST_F(CApi, RendersAsTheLibraryForCppDoes) {
  const TestSound sound(2, 0.7, 44100);
  const TestPicture seen;
  Image image(TestPicture::kWidth, TestPicture::kHeight, 3, 90);
  image.at(4, 7, 1) = 255;
  const earpoint_box box{0.1, 0.2, 0.4, 0.9};
  earpoint_request request{};
  request.struct_size = sizeof(request);
  request.picture = &seen.picture;
  request.speaker_box = &box;
  request.target = {{1.0, 0.5, 0.1}, earpoint_quaternion_from_euler(0.7, 0.1, -0.2)};
  request.gain_db = -3.0;
  request.no_band_extension = 1;
  request.no_limiter = 1;
  const Pose there{{1.0, 0.5, 0.1},
                   quaternion_from_euler({.yaw_rad = 0.7, .pitch_rad = 0.1, .roll_rad = -0.2})};
  const Waveform expected =
      Renderer::open("gtf").render(sound.waveform, {.picture = &image,
                                                    .speaker_box = Box{0.1, 0.2, 0.4, 0.9},
                                                    .target = there,
                                                    .extend_band = false,
                                                    .limit = false,
                                                    .gain_db = -3.0});
  EXPECT_TRUE(same(rendered("gtf", sound, &request), expected));
  // Each member that was set matters: without it the samples differ.
  earpoint_request other = request;
  other.picture = nullptr;
  EXPECT_FALSE(same(rendered("gtf", sound, &other), expected));
  other = request;
  other.speaker_box = nullptr;
  EXPECT_FALSE(same(rendered("gtf", sound, &other), expected));
  other = request;
  other.no_band_extension = 0;
  EXPECT_FALSE(same(rendered("gtf", sound, &other), expected));
}

TEST_F(CApi, FollowsAPathAndPlacesOneChannelAtTheSpeaker) {
  const TestSound sound(1, 0.6, 48000);
  const earpoint_vector3 mouth{2.0, 1.0, 0.0};
  const earpoint_path_point path[] = {{0.0, {{0.5, 1, 0}, {}}}, {0.6, {{1.5, 0, 0}, {}}}};
  earpoint_request request{};
  request.struct_size = sizeof(request);
  request.speaker_m = &mouth;
  request.path = path;
  request.path_count = 2;
  earpoint_renderer_options options{};
  options.struct_size = sizeof(options);
  options.horizontal_fov_rad = 1.2;
  options.threads = 2;
  EXPECT_TRUE(same(
      rendered(nullptr, sound, &request, &options),
      Renderer::open("gtf", {.horizontal_fov_rad = 1.2, .threads = 2})
          .render(sound.waveform, {.speaker_m = Vector3{2.0, 1.0, 0.0},
                                   .path = {{0.0, {{0.5, 1, 0}, {}}}, {0.6, {{1.5, 0, 0}, {}}}}})));
}

TEST_F(CApi, DefaultsAreThoseOfTheLibraryForCpp) {
  const TestSound sound(2, 0.5, 16000);
  const Waveform expected = Renderer::open().render(sound.waveform, {});
  EXPECT_TRUE(same(rendered(nullptr, sound, nullptr), expected));
  earpoint_request request{};
  request.struct_size = sizeof(request);
  earpoint_renderer_options options{};
  options.struct_size = sizeof(options);
  EXPECT_TRUE(same(rendered("gtf", sound, &request, &options), expected));
}

TEST_F(CApi, OutMayBeTheMemoryOfTheSound) {
  TestSound sound(2, 0.5, 16000);
  const Waveform expected = rendered("gtf", sound, nullptr);
  float* const out[] = {sound.waveform.channel(0).data(), sound.waveform.channel(1).data()};
  const OpenRenderer renderer("gtf");
  ASSERT_EQ(earpoint_renderer_render(renderer.handle, &sound.sound, nullptr, out), EARPOINT_OK);
  EXPECT_TRUE(same(sound.waveform, expected));
}

TEST_F(CApi, WarnsAsTheLibraryForCppDoes) {
  const TestSound sound(2, 0.5, 16000);
  earpoint_request request{};
  request.struct_size = sizeof(request);
  request.target.position_m.x = 30.0;
  const OpenRenderer renderer("gtf");
  earpoint_strings* warnings = nullptr;
  ASSERT_EQ(earpoint_renderer_warnings(renderer.handle, &sound.sound, &request, &warnings),
            EARPOINT_OK);
  const auto expected =
      Renderer::open("gtf").warnings(sound.waveform, {.target = {{30.0, 0, 0}, {}}});
  ASSERT_GT(expected.size(), 0u);
  ASSERT_EQ(earpoint_strings_count(warnings), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(earpoint_strings_at(warnings, i), expected[i]);
  }
  EXPECT_EQ(earpoint_strings_at(warnings, expected.size()), nullptr);
  earpoint_strings_destroy(warnings);
}

TEST_F(CApi, StreamsAsTheLibraryForCppDoesWithoutAllocating) {
  const TestSound sound(2, 0.5, 48000);
  const TestPicture seen;
  Image image(TestPicture::kWidth, TestPicture::kHeight, 3, 90);
  image.at(4, 7, 1) = 255;
  const earpoint_box box{0.1, 0.2, 0.4, 0.9};
  const int rounds = 0;
  earpoint_stream_options options{};
  options.struct_size = sizeof(options);
  options.no_limiter = 1;
  options.phase_rounds = &rounds;
  const OpenStream live(OpenRenderer("gtf"), &options);  // which outlives its renderer
  Stream expected_live =
      Renderer::open("gtf").stream({.sample_rate_hz = 48000, .limit = false, .phase_rounds = 0});
  ASSERT_EQ(earpoint_stream_see(live.handle, &seen.picture, &box), EARPOINT_OK);
  expected_live.see(image, Box{0.1, 0.2, 0.4, 0.9});

  TestEars ears(sound);
  Waveform expected(2, sound.waveform.samples(), 48000);
  const std::ptrdiff_t block = 480;
  long allocated = 0;
  for (std::ptrdiff_t at = 0; at < sound.waveform.samples(); at += block) {
    const double x = 1e-4 * static_cast<double>(at);
    const earpoint_vector3 mouth{2.0, x, 0.0};
    const earpoint_pose there{{x, 0.5, 0.0}, earpoint_quaternion_from_euler(x, 0.0, 0.0)};
    expected_live.place_speaker(Vector3{2.0, x, 0.0});
    expected_live.move_to({{x, 0.5, 0.0}, quaternion_from_euler({.yaw_rad = x})});
    const float* in[] = {sound.pointers[0] + at, sound.pointers[1] + at};
    float* out[] = {ears.pointers[0] + at, ears.pointers[1] + at};
    float* expected_out[] = {expected.channel(0).data() + at, expected.channel(1).data() + at};
    expected_live.process(in, expected_out, block);
    const AllocationCount allocations;
    ASSERT_EQ(earpoint_stream_place_speaker(live.handle, &mouth), EARPOINT_OK);
    ASSERT_EQ(earpoint_stream_move_to(live.handle, &there), EARPOINT_OK);
    ASSERT_EQ(earpoint_stream_process(live.handle, in, out, block), EARPOINT_OK);
    allocated += allocations.count();
  }
  EXPECT_EQ(allocated, 0);
  EXPECT_TRUE(same(ears.waveform, expected));
  EXPECT_FALSE(silent(expected));

  std::size_t latency = 0;
  ASSERT_EQ(earpoint_stream_latency(live.handle, &latency), EARPOINT_OK);
  EXPECT_EQ(latency, static_cast<std::size_t>(expected_live.latency_samples()));
  earpoint_vector3 mouth{};
  int known = 0;
  ASSERT_EQ(earpoint_stream_speaker(live.handle, &mouth, &known), EARPOINT_OK);
  ASSERT_EQ(known, 1);
  EXPECT_EQ((Vector3{mouth.x, mouth.y, mouth.z}), expected_live.speaker_m().value());
}

TEST_F(CApi, AStreamStartsAnewAfterReset) {
  const TestSound sound(2, 0.3, 16000);
  earpoint_stream_options options{};
  options.struct_size = sizeof(options);
  options.sample_rate_hz = 16000;
  const OpenStream live(OpenRenderer("gtf"), &options);
  earpoint_vector3 mouth{7.0, 7.0, 7.0};
  int known = 1;
  ASSERT_EQ(earpoint_stream_speaker(live.handle, &mouth, &known), EARPOINT_OK);
  EXPECT_EQ(known, 0);
  EXPECT_EQ(mouth.x, 7.0);
  TestEars first(sound), second(sound);
  for (TestEars* ears : {&first, &second}) {
    ASSERT_EQ(earpoint_stream_see(live.handle, nullptr, nullptr), EARPOINT_OK);
    ASSERT_EQ(earpoint_stream_process(live.handle, sound.pointers.data(), ears->out(),
                                      sound.sound.frames),
              EARPOINT_OK);
    ASSERT_EQ(earpoint_stream_reset(live.handle), EARPOINT_OK);
  }
  EXPECT_TRUE(same(first.waveform, second.waveform));
  EXPECT_FALSE(silent(first.waveform));
}

TEST_F(CApi, ListsAndDescribesModels) {
  earpoint_strings* models = nullptr;
  ASSERT_EQ(earpoint_installed_models(&models), EARPOINT_OK);
  ASSERT_EQ(earpoint_strings_count(models), 1u);
  EXPECT_STREQ(earpoint_strings_at(models, 0), "gtf");
  earpoint_strings_destroy(models);
  int renders = 0, streams = 0;
  ASSERT_EQ(earpoint_describe_model("gtf", &renders, &streams), EARPOINT_OK);
  EXPECT_TRUE(renders == 1 && streams == 1);
  EXPECT_EQ(earpoint_renderer_model(OpenRenderer(nullptr).handle),
            (folder_ / "gtf.safetensors").string());
}

TEST(CApiVersion, IsThatOfItsHeaders) {
  EXPECT_STREQ(earpoint_version(), EARPOINT_VERSION_TEXT);
  EXPECT_EQ(earpoint_version_number(), EARPOINT_VERSION_NUMBER);
}

}  // namespace
}  // namespace earpoint
