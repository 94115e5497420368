#include "failure.h"
#include "test_model.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>

#include <sys/resource.h>

#include <earpoint/core_testing/allocation_count.h>
#include <earpoint/earpoint.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

/// Whether a call failed with this status, and one line of text that contains `part`.
::testing::AssertionResult failed(earpoint_status status, earpoint_status expected,
                                  const std::string& part) {
  const std::string text = earpoint_last_error();
  if (status == expected && text.find(part) != std::string::npos &&
      text.find('\n') == std::string::npos) {
    return ::testing::AssertionSuccess();
  }
  return ::testing::AssertionFailure() << "status " << status << ", text '" << text << "'";
}

class CApiErrors : public TestModel {
 protected:
  void SetUp() override {
    TestModel::SetUp();
    ASSERT_EQ(earpoint_renderer_open("gtf", nullptr, &renderer_), EARPOINT_OK);
    ASSERT_EQ(earpoint_stream_create(renderer_, nullptr, &stream_), EARPOINT_OK);
    ASSERT_EQ(earpoint_renderer_render(renderer_, &sound_.sound, nullptr, before_.out()),
              EARPOINT_OK);
  }
  /// Whatever a test did wrong, the same renderer still gives the same samples.
  void TearDown() override {
    TestEars after(sound_);
    EXPECT_EQ(earpoint_renderer_render(renderer_, &sound_.sound, nullptr, after.out()),
              EARPOINT_OK);
    EXPECT_TRUE(std::ranges::equal(after.waveform.planar(), before_.waveform.planar()));
    EXPECT_EQ(earpoint_stream_process(stream_, sound_.pointers.data(), after.out(), 100),
              EARPOINT_OK);
    earpoint_stream_destroy(stream_);
    earpoint_renderer_close(renderer_);
    TestModel::TearDown();
  }

  /// Renders and expects a failure that leaves `out` as it was.
  ::testing::AssertionResult render_fails(const earpoint_sound& sound,
                                          const earpoint_request* request, earpoint_status status,
                                          const std::string& part) {
    TestEars ears(sound_);
    std::ranges::fill(ears.waveform.planar(), 0.25f);
    const auto result =
        failed(earpoint_renderer_render(renderer_, &sound, request, ears.out()), status, part);
    EXPECT_TRUE(std::ranges::all_of(ears.waveform.planar(), [](float x) { return x == 0.25f; }));
    return result;
  }
  ::testing::AssertionResult render_fails(const earpoint_request& request, earpoint_status status,
                                          const std::string& part) {
    return render_fails(sound_.sound, &request, status, part);
  }

  TestSound sound_{2, 0.5, 16000};
  TestEars before_{sound_};
  earpoint_renderer* renderer_ = nullptr;
  earpoint_stream* stream_ = nullptr;
};

earpoint_request empty_request() {
  earpoint_request request{};
  request.struct_size = sizeof(request);
  return request;
}

TEST_F(CApiErrors, NullPointersAreNamed) {
  const auto usage = EARPOINT_USAGE_ERROR;
  TestEars ears(sound_);
  earpoint_strings* strings = nullptr;
  const float* const in[] = {sound_.pointers[0], nullptr};
  float* const no_ears[] = {ears.pointers[0], nullptr};
  EXPECT_TRUE(failed(earpoint_installed_models(nullptr), usage, "models: is a null"));
  EXPECT_TRUE(failed(earpoint_describe_model(nullptr, nullptr, nullptr), usage, "model: is"));
  EXPECT_TRUE(failed(earpoint_renderer_open("gtf", nullptr, nullptr), usage, "renderer: is"));
  EXPECT_TRUE(failed(earpoint_renderer_render(nullptr, &sound_.sound, nullptr, ears.out()), usage,
                     "renderer: is"));
  EXPECT_TRUE(failed(earpoint_renderer_render(renderer_, nullptr, nullptr, ears.out()), usage,
                     "sound: is"));
  EXPECT_TRUE(failed(earpoint_renderer_render(renderer_, &sound_.sound, nullptr, nullptr), usage,
                     "out: is"));
  EXPECT_TRUE(failed(earpoint_renderer_render(renderer_, &sound_.sound, nullptr, no_ears), usage,
                     "an ear of out: is"));
  EXPECT_TRUE(render_fails({nullptr, 2, 8000, 16000}, nullptr, usage, "sound.channels: is"));
  EXPECT_TRUE(render_fails({in, 2, 8000, 16000}, nullptr, usage, "a channel of the sound: is"));
  EXPECT_TRUE(failed(earpoint_renderer_warnings(renderer_, &sound_.sound, nullptr, nullptr), usage,
                     "warnings: is"));
  EXPECT_TRUE(failed(earpoint_renderer_warnings(nullptr, &sound_.sound, nullptr, &strings), usage,
                     "renderer: is"));
  EXPECT_TRUE(failed(earpoint_stream_create(renderer_, nullptr, nullptr), usage, "stream: is"));
  earpoint_stream* stream = stream_;
  EXPECT_TRUE(failed(earpoint_stream_create(nullptr, nullptr, &stream), usage, "renderer: is"));
  EXPECT_EQ(stream, nullptr);
  EXPECT_TRUE(failed(earpoint_stream_see(nullptr, nullptr, nullptr), usage, "stream: is"));
  EXPECT_TRUE(failed(earpoint_stream_place_speaker(nullptr, nullptr), usage, "stream: is"));
  EXPECT_TRUE(failed(earpoint_stream_move_to(stream_, nullptr), usage, "source_from_target: is"));
  EXPECT_TRUE(failed(earpoint_stream_latency(stream_, nullptr), usage, "frames: is"));
  EXPECT_TRUE(failed(earpoint_stream_speaker(stream_, nullptr, nullptr), usage, "mouth_m: is"));
  EXPECT_TRUE(failed(earpoint_stream_reset(nullptr), usage, "stream: is"));
  earpoint_renderer_close(nullptr);
  earpoint_stream_destroy(nullptr);
  earpoint_strings_destroy(nullptr);
  EXPECT_EQ(earpoint_strings_count(nullptr), 0u);
  EXPECT_EQ(earpoint_strings_at(nullptr, 0), nullptr);
  EXPECT_EQ(earpoint_renderer_model(nullptr), nullptr);
}

TEST_F(CApiErrors, ProcessFailsWithoutAllocating) {
  TestEars ears(sound_);
  const float* const one_in[] = {sound_.pointers[0], nullptr};
  float* const one_out[] = {nullptr, ears.pointers[1]};
  const float* const* in = sound_.pointers.data();
  const AllocationCount allocations;
  const auto usage = EARPOINT_USAGE_ERROR;
  const auto says = [](const char* part) {
    return std::strstr(earpoint_last_error(), part) != nullptr;
  };
  EXPECT_TRUE(earpoint_stream_process(nullptr, in, ears.out(), 9) == usage && says("stream: is"));
  EXPECT_TRUE(earpoint_stream_process(stream_, nullptr, ears.out(), 9) == usage && says("in: is"));
  EXPECT_TRUE(earpoint_stream_process(stream_, one_in, ears.out(), 9) == usage && says("in: is"));
  EXPECT_TRUE(earpoint_stream_process(stream_, in, nullptr, 9) == usage && says("out: is"));
  EXPECT_TRUE(earpoint_stream_process(stream_, in, one_out, 9) == usage && says("out: is"));
  EXPECT_TRUE(earpoint_stream_process(stream_, in, ears.out(), static_cast<size_t>(-1)) == usage &&
              says("frames: more"));
  EXPECT_EQ(earpoint_stream_process(stream_, nullptr, nullptr, 0), EARPOINT_OK);
  EXPECT_EQ(allocations.count(), 0);
}

TEST_F(CApiErrors, BadModelsAreInputErrors) {
  earpoint_renderer* renderer = renderer_;
  EXPECT_TRUE(failed(earpoint_renderer_open("nothing", nullptr, &renderer), EARPOINT_INPUT_ERROR,
                     "nothing: "));
  EXPECT_EQ(renderer, nullptr);
  EXPECT_TRUE(failed(earpoint_describe_model("nothing", nullptr, nullptr), EARPOINT_INPUT_ERROR,
                     "nothing: "));
  ASSERT_EQ(earpoint_renderer_open("input", nullptr, &renderer), EARPOINT_OK);
  earpoint_stream* stream = nullptr;
  EXPECT_TRUE(failed(earpoint_stream_create(renderer, nullptr, &stream), EARPOINT_INPUT_ERROR,
                     "renders whole clips only"));
  earpoint_renderer_close(renderer);
}

TEST_F(CApiErrors, BadOptionsAreNamed) {
  earpoint_renderer* renderer = nullptr;
  earpoint_renderer_options options{};
  options.struct_size = sizeof(options);
  options.horizontal_fov_rad = 90.0;
  EXPECT_TRUE(failed(earpoint_renderer_open("gtf", &options, &renderer), EARPOINT_INPUT_ERROR,
                     "field of view: "));
  options.horizontal_fov_rad = 0.0;
  const double texture = 5.0;
  options.texture = &texture;
  EXPECT_TRUE(failed(earpoint_renderer_open("gtf", &options, &renderer), EARPOINT_INPUT_ERROR,
                     "texture: "));
  options.texture = nullptr;
  options.threads = -1;
  EXPECT_TRUE(failed(earpoint_renderer_open("gtf", &options, &renderer), EARPOINT_USAGE_ERROR,
                     "options.threads: "));
  options.threads = 0;
  options.hrtf = "/nowhere.sofa";
  EXPECT_TRUE(failed(earpoint_renderer_open("dsp", &options, &renderer), EARPOINT_INPUT_ERROR,
                     "/nowhere.sofa"));

  earpoint_stream* stream = nullptr;
  earpoint_stream_options live{};
  live.struct_size = sizeof(live);
  live.sample_rate_hz = 11025;
  EXPECT_TRUE(
      failed(earpoint_stream_create(renderer_, &live, &stream), EARPOINT_INPUT_ERROR, "11025"));
  live.sample_rate_hz = 0;
  const int rounds = 9;
  live.phase_rounds = &rounds;
  EXPECT_TRUE(failed(earpoint_stream_create(renderer_, &live, &stream), EARPOINT_INPUT_ERROR,
                     "phase rounds: "));
}

TEST_F(CApiErrors, SignalProcessingStreamsAndTheUnchangedSoundDoesNot) {
  earpoint_renderer* renderer = nullptr;
  earpoint_stream* stream = nullptr;
  ASSERT_EQ(earpoint_renderer_open("input", nullptr, &renderer), EARPOINT_OK);
  EXPECT_TRUE(failed(earpoint_stream_create(renderer, nullptr, &stream), EARPOINT_INPUT_ERROR,
                     "whole clips only"));
  earpoint_renderer_close(renderer);
  ASSERT_EQ(earpoint_renderer_open("dsp", nullptr, &renderer), EARPOINT_OK);
  ASSERT_EQ(earpoint_stream_create(renderer, nullptr, &stream), EARPOINT_OK);
  const earpoint_box box{0.4, 0.2, 0.6, 1.0};
  EXPECT_TRUE(failed(earpoint_stream_see(stream, nullptr, &box), EARPOINT_INPUT_ERROR,
                     "without a picture"));
  earpoint_stream_destroy(stream);
  earpoint_renderer_close(renderer);
}

TEST_F(CApiErrors, StructsOfOtherVersionsAreReadAsFarAsKnown) {
  earpoint_request request{};
  EXPECT_TRUE(render_fails(request, EARPOINT_USAGE_ERROR, "request.struct_size: expected "));
  struct Later {
    earpoint_request known;
    double added;
  } later{empty_request(), 0.0};
  later.known.struct_size = sizeof(later);
  TestEars ears(sound_);
  EXPECT_EQ(earpoint_renderer_render(renderer_, &sound_.sound, &later.known, ears.out()),
            EARPOINT_OK)
      << earpoint_last_error();
  EXPECT_TRUE(std::ranges::equal(ears.waveform.planar(), before_.waveform.planar()));
  later.added = 1.0;
  EXPECT_TRUE(render_fails(later.known, EARPOINT_INPUT_ERROR, "does not know"));
}

TEST_F(CApiErrors, BadSoundsAreNamed) {
  const float* const three[] = {sound_.pointers[0], sound_.pointers[0], sound_.pointers[0]};
  EXPECT_TRUE(render_fails({three, 3, 8000, 16000}, nullptr, EARPOINT_USAGE_ERROR,
                           "sound.channel_count: expected 1 or 2, found 3"));
  EXPECT_TRUE(render_fails({three, 0, 8000, 16000}, nullptr, EARPOINT_USAGE_ERROR, "found 0"));
  EXPECT_TRUE(
      render_fails({three, 2, 8000, 0}, nullptr, EARPOINT_USAGE_ERROR, "sound.sample_rate_hz: "));
  EXPECT_TRUE(render_fails({three, 2, static_cast<size_t>(-1), 16000}, nullptr,
                           EARPOINT_USAGE_ERROR, "sound.frames: "));
  EXPECT_TRUE(render_fails({three, 2, 8000, 8000}, nullptr, EARPOINT_INPUT_ERROR, "sound: "));
  EXPECT_TRUE(render_fails({three, 2, 160, 16000}, nullptr, EARPOINT_INPUT_ERROR, "sound: "));
  TestSound bad(2, 0.5, 16000);
  bad.waveform.channel(1)[77] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(render_fails(bad.sound, nullptr, EARPOINT_INPUT_ERROR, "sound"));
  std::ranges::fill(bad.waveform.planar(), 0.0f);
  EXPECT_TRUE(render_fails(bad.sound, nullptr, EARPOINT_INPUT_ERROR, "sound"));
}

TEST_F(CApiErrors, BadPlacesAreNamed) {
  const double nan = std::nan("");
  const auto input = EARPOINT_INPUT_ERROR;
  earpoint_request request = empty_request();
  request.target.position_m.y = nan;
  EXPECT_TRUE(render_fails(request, input, "target: "));
  request.target.position_m.y = 1e9;
  EXPECT_TRUE(render_fails(request, input, "target: "));
  request = empty_request();
  request.target.orientation = {1.0, 1.0, 0.0, 0.0};
  EXPECT_TRUE(render_fails(request, input, "target.orientation: expected a unit quaternion"));
  request.target.orientation = {nan, 0.0, 0.0, 0.0};
  EXPECT_TRUE(render_fails(request, input, "target.orientation: "));
  request = empty_request();
  for (const double gain_db : {nan, 1e6}) {
    request.gain_db = gain_db;
    EXPECT_TRUE(render_fails(request, input, "gain: "));
  }
  request = empty_request();
  const earpoint_vector3 nowhere{nan, 0.0, 0.0};
  request.speaker_m = &nowhere;
  EXPECT_TRUE(render_fails(request, input, "speaker: "));
  request = empty_request();
  const earpoint_box bad_box{0.5, 0.5, 0.4, 1.0}, nan_box{nan, 0.0, 1.0, 1.0};
  for (const earpoint_box* box : {&bad_box, &nan_box}) {
    request.speaker_box = box;
    EXPECT_TRUE(render_fails(request, input, "box"));
    EXPECT_TRUE(failed(earpoint_stream_see(stream_, nullptr, box), input, "box"));
  }
  request = empty_request();
  const earpoint_path_point path[] = {{0.0, {}}, {0.0, {}}, {0.6, {{}, {2.0, 0.0, 0.0, 0.0}}}};
  request.path = path;
  request.path_count = 2;
  EXPECT_TRUE(render_fails(request, input, "path"));
  request.path_count = 3;
  EXPECT_TRUE(render_fails(request, input, "path, point 3.orientation: "));
  request.path = nullptr;
  EXPECT_TRUE(render_fails(request, EARPOINT_USAGE_ERROR, "request.path: is a null pointer"));

  EXPECT_TRUE(failed(earpoint_stream_place_speaker(stream_, &nowhere), input, "speaker: "));
  const earpoint_pose far{{0.0, 0.0, 1e9}, {}}, turned{{}, {0.0, 0.0, 0.5, 0.0}};
  EXPECT_TRUE(failed(earpoint_stream_move_to(stream_, &far), input, "earpoint: "));
  EXPECT_TRUE(
      failed(earpoint_stream_move_to(stream_, &turned), input, "source_from_target.orientation: "));
}

TEST_F(CApiErrors, BadPicturesAreNamed) {
  const TestPicture seen;
  const auto fails = [&](const earpoint_picture& picture, const char* part) {
    earpoint_request request = empty_request();
    request.picture = &picture;
    EXPECT_TRUE(
        failed(earpoint_stream_see(stream_, &picture, nullptr), EARPOINT_USAGE_ERROR, part));
    return render_fails(request, EARPOINT_USAGE_ERROR, part);
  };
  EXPECT_TRUE(fails({nullptr, 32, 24, 0}, "picture.rgb: is a null pointer"));
  EXPECT_TRUE(fails({seen.pixels.data(), 0, 24, 0}, "found 0 x 24"));
  EXPECT_TRUE(fails({seen.pixels.data(), 32, -1, 0}, "found 32 x -1"));
  EXPECT_TRUE(fails({seen.pixels.data(), 32, 24, 95}, "picture.row_bytes: expected 96"));
}

TEST_F(CApiErrors, TooLittleMemoryIsAFailureLikeAnother) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers need an address space without limits";
#else
  // In a process of its own, which may use a fixed address space.
  const auto render_with_little = [this] {
    const std::size_t frames = std::size_t{1} << 26;
    const std::vector<float> ear(frames, 0.1f);
    const float* const ears[] = {ear.data(), ear.data()};
    const earpoint_sound sound{ears, 2, frames, 48000};
    const rlimit limit{std::size_t{700} << 20, std::size_t{700} << 20};
    if (::setrlimit(RLIMIT_AS, &limit) != 0) std::exit(9);
    float nothing = 0.0f;
    float* const out[] = {&nothing, &nothing};
    const earpoint_status status = earpoint_renderer_render(renderer_, &sound, nullptr, out);
    std::fprintf(stderr, "%s", earpoint_last_error());
    std::exit(status);
  };
  EXPECT_EXIT(render_with_little(), ::testing::ExitedWithCode(EARPOINT_OUT_OF_MEMORY),
              "^out of memory$");
#endif
}

TEST_F(CApiErrors, EachThreadHasItsOwnText) {
  EXPECT_TRUE(failed(earpoint_stream_reset(nullptr), EARPOINT_USAGE_ERROR, "stream: "));
  std::thread([] {
    EXPECT_STREQ(earpoint_last_error(), "");
    EXPECT_TRUE(failed(earpoint_describe_model("nothing", nullptr, nullptr), EARPOINT_INPUT_ERROR,
                       "nothing: "));
  }).join();
  EXPECT_TRUE(std::string(earpoint_last_error()).starts_with("stream: "));
}

TEST(CApiBorder, EveryExceptionEndsInAStatus) {
  const auto end_of = [](auto thrown) { return c_api::guarded([&] { throw thrown; }); };
  EXPECT_EQ(c_api::guarded([] {}), EARPOINT_OK);
  EXPECT_TRUE(failed(end_of(InputError("file", "broken")), EARPOINT_INPUT_ERROR, "file: broken"));
  EXPECT_TRUE(failed(end_of(std::bad_alloc()), EARPOINT_OUT_OF_MEMORY, "out of memory"));
  EXPECT_TRUE(
      failed(end_of(std::logic_error("a check\nfailed")), EARPOINT_USAGE_ERROR, "a check failed"));
  EXPECT_TRUE(failed(end_of(std::length_error("long")), EARPOINT_USAGE_ERROR, "long"));
  EXPECT_TRUE(failed(end_of(std::runtime_error("disk")), EARPOINT_INTERNAL_ERROR, "disk"));
  EXPECT_TRUE(failed(end_of(7), EARPOINT_INTERNAL_ERROR, "unknown failure"));
}

}  // namespace
}  // namespace earpoint
