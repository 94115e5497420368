// The built plugins, loaded as workstations load them, with the shipped networks on the bundled
// clip.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <numbers>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/energy.h>
#include <earpoint/core_testing/allocation_count.h>
#include <earpoint/renderer.h>
#include <earpoint/waveform.h>

#include "bundled_clip.h"
#include "hosted_plugin.h"

namespace earpoint::plugin {
namespace {

const std::string kBundles = EARPOINT_PLUGIN_DIR;

struct Format {
  const char* name;
  std::function<std::unique_ptr<HostedPlugin>(int sample_rate_hz)> load;
};

void PrintTo(const Format& format, std::ostream* to) { *to << format.name; }

class PluginFormat : public ::testing::TestWithParam<Format> {
 protected:
  [[nodiscard]] static std::unique_ptr<HostedPlugin> load(int sample_rate_hz = 48000) {
    return GetParam().load(sample_rate_hz);
  }
};

INSTANTIATE_TEST_SUITE_P(
    , PluginFormat,
    ::testing::Values(
        Format{"Lv2",
               [](int rate_hz) {
                 return host_lv2(kBundles + "/lv2/earpoint.lv2", rate_hz, Lv2Host::full);
               }},
        Format{"Lv2InABareHost",
               [](int rate_hz) {
                 return host_lv2(kBundles + "/lv2/earpoint.lv2", rate_hz, Lv2Host::bare);
               }},
        Format{"Clap",
               [](int rate_hz) { return host_clap(kBundles + "/clap/earpoint.clap", rate_hz); }},
        Format{"Vst3",
               [](int rate_hz) { return host_vst3(kBundles + "/vst3/earpoint.vst3", rate_hz); }}),
    [](const auto& of) { return of.param.name; });

/// The settings of bundled_settings().
void set_bundled(HostedPlugin& plugin) {
  plugin.set(kEarpointX, 1.49F);
  plugin.set(kEarpointY, -0.2F);
  plugin.set(kYaw, -45.0F);
  plugin.set(kSpeakerGiven, 1.0F);
  plugin.set(kSpeakerX, 1.89F);
  plugin.set(kSpeakerY, 0.196F);
  plugin.set(kSpeakerZ, 0.147F);
}

/// What the plugin holds of them: floats, that VST3 hosts scale to 0..1 and back.
Settings settings_of(const HostedPlugin& plugin) {
  const auto degrees = [&](ParameterId id) { return radians_from_degrees(plugin.get(id)); };
  return {
      .earpoint = {{plugin.get(kEarpointX), plugin.get(kEarpointY), plugin.get(kEarpointZ)},
                   quaternion_from_euler({.yaw_rad = degrees(kYaw), .pitch_rad = degrees(kPitch)})},
      .speaker_m = Vector3{plugin.get(kSpeakerX), plugin.get(kSpeakerY), plugin.get(kSpeakerZ)}};
}

TEST_P(PluginFormat, EqualsTheLibrarysStreamBitForBit) {
  const Waveform sound = part_of(bundled_clip(), 0, 2 * 48000);
  const auto plugin = load();
  set_bundled(*plugin);
  const Waveform result = plugin->process(sound, 480 + 7);
  const Settings settings = settings_of(*plugin);
  EXPECT_TRUE(same(result, stream_of_library("gtf", settings, sound)));
  EXPECT_NEAR(settings.earpoint.position_m.x, 1.49, 1e-5);  // as the plugin was told
  EXPECT_NEAR(settings.speaker_m->y, 0.196, 1e-5);
  EXPECT_GT(energy(result.channel(0)), 0.01 * energy(sound.channel(0)));
  EXPECT_EQ(plugin->get(kStatus), static_cast<double>(Status::renders));
  EXPECT_EQ(plugin->restart_requests(), 0);
}

TEST_P(PluginFormat, LocatesTheSpeakerWhereNoneIsGiven) {
  const Waveform sound = part_of(bundled_clip(), 0, 48000);
  const auto plugin = load();
  const Waveform result = plugin->process(sound, 512);
  EXPECT_TRUE(same(result, stream_of_library("gtf", {}, sound)));
  // In front, somewhere in a room.
  EXPECT_GT(plugin->get(kLocatedX), 0.1);
  EXPECT_LT(plugin->get(kLocatedX), 10.0);
}

TEST_P(PluginFormat, RunsAtTheHostsRate) {
  for (const int rate_hz : {16000, 44100, 96000}) {
    Waveform sound(2, rate_hz / 2, rate_hz);
    for (int c = 0; c < 2; ++c) {
      std::copy_n(bundled_clip().channel(c).begin() + 48000, sound.samples(),
                  sound.channel(c).begin());
    }
    const auto plugin = load(rate_hz);
    EXPECT_TRUE(same(plugin->process(sound, 256), stream_of_library("gtf", {}, sound))) << rate_hz;
  }
}

TEST_P(PluginFormat, PassesSoundOfOtherRatesAndSaysSo) {
  Waveform sound(2, 4000, 11025);
  std::copy_n(bundled_clip().planar().begin() + 48000, sound.planar().size(),
              sound.planar().begin());
  const auto plugin = load(11025);
  EXPECT_TRUE(same(plugin->process(sound, 300), sound));
  EXPECT_EQ(plugin->latency_samples(), 0);
  EXPECT_EQ(plugin->get(kStatus), static_cast<double>(Status::rate_not_supported));
}

TEST_P(PluginFormat, KeepsToTheRangeOfAParameterIfTheHostDoesNot) {
  const Waveform sound = part_of(bundled_clip(), 0, 24000);
  const auto with = [&](double metres, double degrees, double model) {
    const auto plugin = load();
    plugin->set(kEarpointX, metres);
    plugin->set(kYaw, degrees);
    plugin->set(kModel, model);
    return plugin->process(sound, 512);
  };
  // 10 km are more than a stream takes.
  EXPECT_TRUE(same(with(1e9, -1e30, 1e30), with(20.0, -180.0, 15.0)));
}

TEST_P(PluginFormat, TellsItsLatencyAndBypassesWithIt) {
  const auto plugin = load();
  plugin->set(kBypass, 1.0);
  Waveform impulse(2, 9600, 48000);
  impulse.channel(0)[100] = 1.0F;
  impulse.channel(1)[200] = -0.5F;
  const Waveform result = plugin->process(impulse, 333);
  ASSERT_GT(plugin->latency_samples(), 480);  // a hop at least
  ASSERT_LT(plugin->latency_samples(), 4800);
  EXPECT_TRUE(same(result, delayed(impulse, plugin->latency_samples())));
}

/// The delay in samples at which `late` is most like `sound`, from 0 to `longest`.
std::ptrdiff_t delay_between(std::span<const float> sound, std::span<const float> late,
                             std::ptrdiff_t longest) {
  std::ptrdiff_t best = 0;
  double highest = 0.0;
  for (std::ptrdiff_t lag = 0; lag <= longest; ++lag) {
    double product = 0.0;
    for (std::ptrdiff_t i = lag; i < std::ssize(sound); ++i) {
      product += double{sound[i - lag]} * late[i];
    }
    if (product > highest) {
      highest = product;
      best = lag;
    }
  }
  return best;
}

TEST_P(PluginFormat, RendersAsLateAsItSays) {
  // A click above the network's band goes around it, as late as what goes through. In the band a
  // voice's period of 10 ms would make the delay ambiguous.
  Waveform click(2, 9600, 48000);
  for (int i = -200; i <= 200; ++i) {
    const double wave = std::cos(2.0 * std::numbers::pi * 12000.0 * i / 48000.0);
    const auto sample = static_cast<float>(0.5 * wave * std::exp(-0.5 * std::pow(i / 30.0, 2)));
    click.channel(0)[1000 + i] = click.channel(1)[1000 + i] = sample;
  }
  const auto plugin = load();
  const Waveform result = plugin->process(click, 512);
  for (int ear = 0; ear < 2; ++ear) {
    EXPECT_EQ(delay_between(click.channel(ear), result.channel(ear), 4800),
              plugin->latency_samples());
  }
}

TEST_P(PluginFormat, RestartsFromSilence) {
  const Waveform sound = part_of(bundled_clip(), 48000, 24000);
  const auto plugin = load();
  const Waveform first = plugin->process(sound, 512);
  plugin->restart();
  EXPECT_TRUE(same(plugin->process(sound, 512), first));
}

TEST_P(PluginFormat, AllocatesNothingWhileItRuns) {
  const AllocationCount loading;
  const auto plugin = load();
  ASSERT_GT(loading.count(), 1000) << "what the plugin allocates is not counted";
  plugin->set(kModel, 1);
  const Waveform sound = part_of(bundled_clip(), 48000, 512);
  Waveform result(2, 512, 48000);
  const float* const in[] = {sound.channel(0).data(), sound.channel(1).data()};
  float* const out[] = {result.channel(0).data(), result.channel(1).data()};
  plugin->process(in, out, 512);
  plugin->set(kModel, 0);
  plugin->set(kEarpointX, 1.0);
  const AllocationCount running;
  for (int block = 0; block < 200; ++block) plugin->process(in, out, 512);  // 2 s: with the switch
  EXPECT_EQ(running.count(), 0);
}

TEST_P(PluginFormat, OffersTheNetworksThatStream) {
  EXPECT_EQ(load()->model_names(), (std::vector<std::string>{"gtf", "enhance"}));
  const Waveform sound = part_of(bundled_clip(), 48000, 24000);
  const auto plugin = load();
  plugin->set(kModel, 1);
  const Waveform result = plugin->process(sound, 512);
  // All models are as late as the latest. LV2 tells its latency once it has run.
  const std::ptrdiff_t pad =
      plugin->latency_samples() -
      Renderer::open("enhance").stream({.sample_rate_hz = 48000}).latency_samples();
  ASSERT_GE(pad, 0);
  EXPECT_TRUE(same(result, delayed(stream_of_library("enhance", {}, sound), pad)));
}

constexpr std::ptrdiff_t kSecond = 48000;

/// 200 Hz in both ears, so that a click stands alone above it.
Waveform tone(std::ptrdiff_t samples) {
  Waveform sound(2, samples, 48000);
  for (std::ptrdiff_t i = 0; i < samples; ++i) {
    const double phase = 2.0 * std::numbers::pi * 200.0 * static_cast<double>(i) / 48000.0;
    sound.channel(0)[i] = sound.channel(1)[i] = static_cast<float>(0.2 * std::sin(phase));
  }
  return sound;
}

/// The largest click: of differences of fourth order, which attenuate 200 Hz at 48 kHz by 126 dB,
/// and a step not at all.
double largest_click(std::span<const float> sound) {
  double largest = 0.0;
  for (std::size_t i = 4; i < sound.size(); ++i) {
    const double x = sound[i] - 4.0 * sound[i - 1] + 6.0 * sound[i - 2] - 4.0 * sound[i - 3] +
                     double{sound[i - 4]};
    largest = std::max(largest, std::abs(x));
  }
  return largest;
}

double largest_click(const Waveform& sound) {
  return std::max(largest_click(sound.channel(0)), largest_click(sound.channel(1)));
}

/// The sound of two more seconds of the tone, at whose beginning parameters change.
Waveform changed(HostedPlugin& plugin, const std::function<void(HostedPlugin&)>& change) {
  (void)plugin.process(tone(2 * kSecond), 512);
  change(plugin);
  return plugin.process(tone(2 * kSecond), 512);
}

/// `first`, and from its loudest sample after half its length on `second`: what must not be heard.
Waveform cut_between(const Waveform& first, const Waveform& second) {
  const std::ptrdiff_t half = first.samples() / 2;
  const auto here = first.channel(0).subspan(half, 480);
  const auto place = half + (std::ranges::max_element(here) - here.begin());
  Waveform cut = first;
  for (int ear = 0; ear < 2; ++ear) {
    std::copy(second.channel(ear).begin() + place, second.channel(ear).end(),
              cut.channel(ear).begin() + place);
  }
  return cut;
}

/// @param most  that `changing` may click, as a multiple of what both do without a change
void expect_no_click(const Waveform& before, const Waveform& after, const Waveform& changing,
                     double most) {
  const double without = std::max(largest_click(before), largest_click(after));
  EXPECT_GT(largest_click(cut_between(before, after)), 3.0 * without) << "no click could be told";
  EXPECT_LT(largest_click(changing), most * without);
}

TEST_P(PluginFormat, SwitchesModelsWithoutAClick) {
  const auto run = [&](int first, int second) {
    const auto plugin = load();
    plugin->set(kModel, first);
    return changed(*plugin, [&](HostedPlugin& same) { same.set(kModel, second); });
  };
  const Waveform gtf = run(0, 0);
  const Waveform switched = run(0, 1);
  // It begins as the one and ends as the other.
  EXPECT_TRUE(same(part_of(switched, 0, kSecond), part_of(gtf, 0, kSecond)));
  EXPECT_FALSE(same(switched, gtf));
  // The other has heard a second when it is faded in. A sum of both by parts has no more than the
  // larger.
  const auto other = load();
  other->set(kModel, 1);
  const Waveform enhanced = other->process(tone(2 * kSecond), 512);
  expect_no_click(part_of(gtf, kSecond, kSecond), part_of(enhanced, kSecond, kSecond),
                  part_of(switched, kSecond, kSecond), 1.05);
}

TEST_P(PluginFormat, MovesWithoutAClick) {
  const auto at = [](double metres) {
    return [metres](HostedPlugin& plugin) {
      plugin.set(kEarpointX, metres);
      plugin.set(kYaw, 90.0 * metres);
      plugin.set(kSpeakerGiven, 1);
    };
  };
  const auto run = [&](double first, double second) {
    const auto plugin = load();
    at(first)(*plugin);
    return changed(*plugin, at(second));
  };
  // Frames of 25 ms overlap. Measured: 1.1 to 2.2 with different weights; a cut is above 3.
  expect_no_click(run(0, 0), run(1, 1), run(0, 1), 2.6);
}

TEST(ClapPlugin, KeepsItsParametersInTheSession) {
  const auto plugin = host_clap(kBundles + "/clap/earpoint.clap", 48000);
  set_bundled(*plugin);
  plugin->set(kModel, 1);
  plugin->set(kBypass, 1);
  (void)plugin->process(Waveform(2, 64, 48000), 64);
  const auto other = host_clap(kBundles + "/clap/earpoint.clap", 48000);
  load_clap_state(*other, save_clap_state(*plugin));
  for (std::uint32_t id = kEarpointX; id < kStatus; ++id) {
    // They are written with six digits after the point.
    EXPECT_NEAR(other->get(ParameterId{id}), plugin->get(ParameterId{id}), 1e-6) << id;
  }
  EXPECT_EQ(other->get(kModel), 1.0);
}

}  // namespace
}  // namespace earpoint::plugin
