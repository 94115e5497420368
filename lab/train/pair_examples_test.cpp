#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/audio/energy.h>
#include <earpoint/audio/gcc_phat.h>
#include <earpoint/core/file.h>
#include <earpoint/dataset_testing/tiny_dataset.h>
#include <earpoint/error.h>
#include <earpoint/pose.h>
#include <earpoint/train/example_loader.h>
#include <earpoint/train/train_config.h>
#include <earpoint/train/training_task.h>
#include <earpoint/vigas/description.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class PairExamplesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("pair_examples." + std::to_string(::getpid()));
    fs::remove_all(folder_);
    write_tiny_dataset(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] PairOptions options() const {
    PairOptions options;
    options.data = folder_;
    options.samples = 8000;
    options.cache_bytes = 50'000'000;
    return options;
  }

  [[nodiscard]] static PairExamples examples(const PairOptions& options) {
    const ViGasDescription description =
        vigas_config_from_json(R"({"picture": {"width_px": 32, "height_px": 32}})", "x", true)
            .description;
    return {options, [=](const PairSample& sample) { return vigas_example(description, sample); }};
  }

  fs::path folder_;
};

TEST_F(PairExamplesTest, AnySpeechIsHeardAtTheSamePlaces) {
  PairOptions any = options();
  any.any_speech = true;
  // The draw for mirroring comes after those of the speech and would differ.
  any.mirror = false;
  PairOptions own = any;
  own.any_speech = false;
  const PairExamples retold = examples(any);
  const PairExamples told = examples(own);
  int changed = 0;
  for (std::uint64_t number = 0; number < 8; ++number) {
    const PairSample a = told.training_sample(number);
    const PairSample b = retold.training_sample(number);
    EXPECT_EQ(a.speaker_m, b.speaker_m);
    EXPECT_EQ(a.source_from_target.position_m, b.source_from_target.position_m);
    changed += std::ranges::equal(a.source.planar(), b.source.planar()) ? 0 : 1;
  }
  EXPECT_GE(changed, 4);
}

TEST_F(PairExamplesTest, ANumberIsAnExampleAndSeedsDiffer) {
  const PairExamples one = examples(options());
  const PairExamples same = examples(options());
  PairOptions reseeded = options();
  reseeded.seed = 2;
  const PairExamples other = examples(reseeded);
  // In another order, from another cache.
  const TrainingExample later = same.training(7);
  const TrainingExample first = same.training(0);
  EXPECT_EQ(one.training(0).source, first.source);
  EXPECT_EQ(one.training(7).target, later.target);
  EXPECT_EQ(one.training(7).picture, later.picture);
  EXPECT_NE(one.training(7).target, other.training(7).target);
  EXPECT_EQ(later.source.size(), 16000U);
  EXPECT_EQ(later.picture.size(), 3U * 32 * 32);
  EXPECT_EQ(later.inputs.at("tgt_rotation").size(), 6U);
}

TEST_F(PairExamplesTest, DrawsEveryPairAndSpeaker) {
  const PairExamples source = examples(options());
  std::set<std::pair<double, double>> pairs;  // by the position of the target from the source
  for (std::uint64_t n = 0; n < 120; ++n) {
    const Vector3 seen = source.training_sample(n).source_from_target.position_m;
    pairs.emplace(seen.x, std::abs(seen.y));
  }
  // Two clips of three viewpoints: six ordered pairs each.
  EXPECT_EQ(pairs.size(), 12U);
}

TEST_F(PairExamplesTest, MirroringCanBeTurnedOffAndChangesNothingElse) {
  const PairExamples mirrored_half = examples(options());
  PairOptions plain = options();
  plain.mirror = false;
  const PairExamples as_it_is = examples(plain);
  int swapped = 0;
  for (std::uint64_t n = 0; n < 40; ++n) {
    const PairSample one = mirrored_half.training_sample(n);
    const PairSample two = as_it_is.training_sample(n);
    const bool is_mirrored =
        one.source_from_target.position_m.y != two.source_from_target.position_m.y;
    EXPECT_TRUE(std::ranges::equal(one.source.channel(is_mirrored ? 1 : 0), two.source.channel(0)));
    swapped += is_mirrored ? 1 : 0;
  }
  // Forty fair draws: 20 +- 3.2.
  EXPECT_GT(swapped, 7);
  EXPECT_LT(swapped, 33);
}

TEST_F(PairExamplesTest, SpoilsPicturesAndHidesBoxesAsOftenAsAskedAndChangesNothingElse) {
  PairOptions poor = options();
  poor.spoilt_pictures = 0.5;
  poor.hidden_boxes = 0.25;
  const PairExamples plain = examples(options());
  const PairExamples spoilt = examples(poor);
  int pictures = 0;
  int boxes = 0;
  int seen = 0;
  constexpr int kDraws = 200;
  for (std::uint64_t n = 0; n < kDraws; ++n) {
    const PairSample one = plain.training_sample(n);
    const PairSample two = spoilt.training_sample(n);
    EXPECT_TRUE(std::ranges::equal(one.source.planar(), two.source.planar()));
    EXPECT_EQ(one.source_from_target, two.source_from_target);
    EXPECT_EQ(one.picture->width(), two.picture->width());
    pictures += std::ranges::equal(one.picture->pixels(), two.picture->pixels()) ? 0 : 1;
    seen += one.speaker_box ? 1 : 0;
    boxes += one.speaker_box && !two.speaker_box ? 1 : 0;
  }
  // 100 +- 7 of 200 draws are spoilt; an eighth of them may get their own picture again. A quarter
  // of the visible ones loses the box, +- 6.
  EXPECT_GT(pictures, 60);
  EXPECT_LT(pictures, 125);
  EXPECT_GT(boxes, seen / 4 - 25);
  EXPECT_LT(boxes, seen / 4 + 25);
  EXPECT_GT(boxes, 0);
}

TEST_F(PairExamplesTest, MakesSpeechFaintAsOftenAsAskedInNoiseThatIsNot) {
  PairOptions noisy = options();
  noisy.mirror = false;
  noisy.target = PairTarget::near_microphone;
  const PairExamples clean = examples(noisy);
  noisy.ambient_db = -40.0;
  noisy.separate = false;
  const PairExamples plain = examples(noisy);
  noisy.faint_speech = 0.5;
  const PairExamples some = examples(noisy);
  int faint = 0;
  constexpr int kDraws = 100;
  for (std::uint64_t n = 0; n < kDraws; ++n) {
    const PairSample one = plain.training_sample(n);
    const PairSample two = some.training_sample(n);
    EXPECT_EQ(one.source_from_target, two.source_from_target);
    const double gain = std::sqrt(energy(two.dry.planar()) / energy(one.dry.planar()));
    // -60 dB and nothing, and float samples.
    EXPECT_GT(gain, 0.999e-3);
    EXPECT_LT(gain, 1.0 + 1e-6);
    if (gain > 1.0 - 1e-6) continue;
    ++faint;
    // What is to be found is as faint.
    EXPECT_NEAR(energy(two.target.planar()), gain * gain * energy(one.target.planar()),
                1e-5 * energy(two.target.planar()));
    // Room noise is the same in both, so that their difference is the noise that was added and the
    // speech that is missing.
    const PairSample speech = clean.training_sample(n);
    std::vector<float> added(two.source.planar().size());
    for (std::size_t i = 0; i < added.size(); ++i) {
      added[i] = two.source.planar()[i] - one.source.planar()[i] +
                 static_cast<float>(1.0 - gain) * speech.source.planar()[i];
    }
    // White noise at 48 kHz has a third of its power within the band; of the darkest noise, a
    // second has some forty independent values.
    EXPECT_GT(energy(added) / static_cast<double>(added.size()), 0.1e-4);
  }
  // Fifty fair draws of a hundred: +- 5.
  EXPECT_GT(faint, 30);
  EXPECT_LT(faint, 70);
}

/// What is in `mixed` besides `alone`.
Waveform added(const Waveform& mixed, const Waveform& alone) {
  Waveform rest = mixed;
  for (std::size_t i = 0; i < rest.planar().size(); ++i) rest.planar()[i] -= alone.planar()[i];
  return rest;
}

TEST_F(PairExamplesTest, TheSecondVoiceIsHeardFromWhereTheOtherPersonIs) {
  PairOptions alone = options();
  alone.mirror = false;
  PairOptions both = alone;
  both.second_voices = 1.0;
  const PairExamples one_speaks = examples(alone);
  const PairExamples both_speak = examples(both);
  int told = 0;
  for (std::uint64_t n = 0; n < 20; ++n) {
    const PairSample one = one_speaks.training_sample(n);
    const PairSample two = both_speak.training_sample(n);
    EXPECT_EQ(one.speaker_m, two.speaker_m);
    EXPECT_EQ(one.speaker_box.has_value(), two.speaker_box.has_value());
    EXPECT_TRUE(std::ranges::equal(one.dry.planar(), two.dry.planar()));
    // The people stand at either side of the origin.
    const Vector3 here = transform_point(one.world_from_source, one.speaker_m);
    const Vector3 other =
        transform_point(inverse(one.world_from_source), {-here.x, -here.y, here.z});
    const auto expect_side = [&](const Waveform& voice, const Vector3& seen) {
      EXPECT_GT(energy(voice.planar()), 0.0);
      const double left = std::sin(spherical_from_cartesian(seen).azimuth_rad);
      if (std::abs(left) < 0.2) return;  // 2 dB between the ears, and the tail's
      ++told;
      EXPECT_EQ(energy(voice.channel(0)) > energy(voice.channel(1)), left > 0.0);
    };
    expect_side(added(two.source, one.source), other);
    expect_side(added(two.target, one.target),
                transform_point(inverse(one.source_from_target), other));
  }
  EXPECT_GT(told, 20);
}

TEST_F(PairExamplesTest, TellsTheBoxThatIsAskedForAndLeavesTheTruthToLearnFrom) {
  PairOptions unseen = options();
  unseen.boxes = SpeakerBoxes::none;
  // The pictures are noise, in which nobody is to be found.
  PairOptions looked_for = options();
  looked_for.boxes = SpeakerBoxes::detected;
  const PairExamples plain = examples(options());
  int seen = 0;
  for (const PairOptions& told : {unseen, looked_for}) {
    const PairExamples others = examples(told);
    for (std::uint64_t n = 0; n < 8; ++n) {
      const PairSample one = plain.training_sample(n);
      const PairSample two = others.training_sample(n);
      seen += one.speaker_box ? 1 : 0;
      EXPECT_FALSE(two.speaker_box);
      EXPECT_EQ(one.speaker_m, two.speaker_m);
      EXPECT_EQ(one.source_from_target, two.source_from_target);
      EXPECT_TRUE(std::ranges::equal(one.source.planar(), two.source.planar()));
    }
  }
  EXPECT_GT(seen, 0);
}

TEST_F(PairExamplesTest, ShowsPicturesAsACameraOfAnotherShapeTakesThem) {
  PairOptions wide = options();
  wide.wide_pictures = 1.0;
  const PairExamples plain = examples(options());
  const PairExamples cut = examples(wide);
  int cut_boxes = 0;
  for (std::uint64_t n = 0; n < 20; ++n) {
    const PairSample one = plain.training_sample(n);
    const PairSample two = cut.training_sample(n);
    EXPECT_TRUE(std::ranges::equal(one.source.planar(), two.source.planar()));
    // 36 of 64 rows are left, with 14 grey rows on either side.
    for (const int y : {0, 13, 50, 63}) EXPECT_EQ(two.picture->at(5, y, 0), 128);
    for (const int y : {14, 49}) {
      EXPECT_EQ(two.picture->at(5, y, 0), one.picture->at(5, y, 0));
    }
    ASSERT_EQ(one.speaker_box.has_value(), two.speaker_box.has_value());
    if (!one.speaker_box) continue;
    EXPECT_EQ(two.speaker_box->x_min, one.speaker_box->x_min);
    EXPECT_DOUBLE_EQ(two.speaker_box->y_min, std::max(one.speaker_box->y_min, 7.0 / 32));
    EXPECT_DOUBLE_EQ(two.speaker_box->y_max, std::min(one.speaker_box->y_max, 25.0 / 32));
    ++cut_boxes;
  }
  EXPECT_GT(cut_boxes, 5);
}

TEST_F(PairExamplesTest, DrawsClipsOfAllFoldersAlikeAndValidatesOnTheFirst) {
  const fs::path other = folder_ / "other";
  write_tiny_dataset(other, {.clips = 6, .seed = 2});
  PairOptions joined = options();
  joined.mirror = false;
  const PairExamples alone = examples(joined);
  joined.data = other;
  const PairExamples others = examples(joined);
  joined.data = folder_;
  joined.more_data = {other};
  const PairExamples both = examples(joined);
  // Positions of targets show which folder pairs are from.
  const auto places_of = [](const PairExamples& source, int draws) {
    std::multiset<double> places;
    for (int n = 0; n < draws; ++n) {
      places.insert(source.training_sample(n).source_from_target.position_m.x);
    }
    return places;
  };
  const std::multiset<double> own = places_of(alone, 200);
  const std::multiset<double> theirs = places_of(others, 600);
  int of_first = 0;
  for (const double place : places_of(both, 200)) {
    EXPECT_TRUE(own.contains(place) || theirs.contains(place));
    of_first += own.contains(place) ? 1 : 0;
  }
  // Two of eight clips: of 200 draws 50 +- 6.
  EXPECT_GT(of_first, 25);
  EXPECT_LT(of_first, 75);
  ASSERT_EQ(both.validations(), alone.validations());
  EXPECT_EQ(both.validation(0)->target, alone.validation(0)->target);
}

TEST_F(PairExamplesTest, LeavesOutPairsBeyondTheLimits) {
  PairOptions limited = options();
  limited.farthest_move_m = 2.5;
  limited.most_gain_db = 1.0;
  const PairExamples all = examples(options());
  const PairExamples some = examples(limited);
  int beyond = 0;
  for (std::uint64_t n = 0; n < 60; ++n) {
    const auto is_beyond = [](const PairSample& sample) {
      return norm(sample.source_from_target.position_m) > 2.5 ||
             energy(sample.target.planar()) > 1.259 * energy(sample.source.planar());
    };
    EXPECT_FALSE(is_beyond(some.training_sample(n))) << n;
    beyond += is_beyond(all.training_sample(n)) ? 1 : 0;
  }
  EXPECT_GT(beyond, 10);
  limited.farthest_move_m = 0.1;
  EXPECT_THROW(static_cast<void>(examples(limited).training_sample(0)), InputError);
}

TEST_F(PairExamplesTest, GccPhatTakesOutTheWaysDifference) {
  PairOptions kept = options();
  kept.alignment = Alignment::none;
  PairOptions aligned = options();
  aligned.alignment = Alignment::gcc_phat;
  const PairExamples later = examples(kept);
  const PairExamples together = examples(aligned);
  // Delay of the mean of both ears, which alignment uses.
  const auto delay_of = [](const PairSample& sample) {
    const auto mean = [](const Waveform& sound) {
      std::vector<float> samples(sound.channel(0).begin(), sound.channel(0).end());
      for (std::size_t i = 0; i < samples.size(); ++i) samples[i] += sound.channel(1)[i];
      return samples;
    };
    return std::abs(gcc_phat_delay_samples(mean(sample.target), mean(sample.source), 300.0));
  };
  double kept_delay = 0.0;
  for (std::uint64_t n = 0; n < 10; ++n) {
    kept_delay = std::max(kept_delay, delay_of(later.training_sample(n)));
    // Alignment is to whole samples.
    EXPECT_LT(delay_of(together.training_sample(n)), 1.0) << n;
  }
  EXPECT_GT(kept_delay, 5.0);
}

TEST_F(PairExamplesTest, SeparationTakesAmbientSoundOut) {
  PairOptions noisy = options();
  noisy.ambient_db = -20.0;
  noisy.separate = false;
  PairOptions separated = noisy;
  separated.separate = true;
  const PairExamples clean = examples(options());
  const auto noise = [&](const PairOptions& of) {
    const PairSample with = examples(of).training_sample(3);
    const PairSample without = clean.training_sample(3);
    std::vector<float> difference(8000);
    for (std::size_t i = 0; i < difference.size(); ++i) {
      difference[i] = with.source.channel(0)[i] - without.source.channel(0)[i];
    }
    return 10.0 * std::log10(energy(difference) / 8000.0);
  };
  // A 20 Hz noise has some ten independent values in half a second: good to 3 dB.
  EXPECT_NEAR(noise(noisy), -20.0, 3.0);
  // About a sixth of its energy is above 80 Hz.
  EXPECT_LT(noise(separated), -25.0);
}

TEST_F(PairExamplesTest, NearMicrophonesHearNoNoise) {
  PairOptions quiet = options();
  quiet.target = PairTarget::near_microphone;
  PairOptions noisy = quiet;
  noisy.ambient_db = -20.0;
  for (std::uint64_t n = 0; n < 4; ++n) {
    const PairSample without = examples(quiet).training_sample(n);
    const PairSample with = examples(noisy).training_sample(n);
    EXPECT_TRUE(std::ranges::equal(with.target.planar(), without.target.planar()));
    EXPECT_FALSE(std::ranges::equal(with.source.planar(), without.source.planar()));
    EXPECT_TRUE(std::ranges::equal(with.target.channel(0), with.target.channel(1)));
    EXPECT_EQ(norm(with.source_from_target.position_m), 0.0);
  }
  EXPECT_EQ(examples(noisy).validation(0)->target, examples(quiet).validation(0)->target);
}

TEST_F(PairExamplesTest, ValidationIsTheFrozenListEvenlySpread) {
  PairOptions few = options();
  few.validation_pairs = 3;
  EXPECT_EQ(examples(few).validations(), 3U);
  few.validation_pairs = 0;
  const PairExamples all = examples(few);
  ASSERT_EQ(all.validations(), 6U);
  // Whole seconds, aligned, regardless of the options of training.
  EXPECT_EQ(all.validation(0)->source.size(), 32000U);
  few.alignment = Alignment::none;
  few.seed = 9;
  EXPECT_EQ(all.validation(5)->target, examples(few).validation(5)->target);
}

TEST_F(PairExamplesTest, BadFilesAreNamedAndLeftOutOnRequest) {
  write_file(folder_ / "train/room/0/view_1.png", std::string_view("no picture"));
  EXPECT_THROW(
      {
        const PairExamples strict = examples(options());
        for (std::uint64_t n = 0; n < 40; ++n) static_cast<void>(strict.training(n));
      },
      InputError);
  PairOptions lenient = options();
  std::string complaints;
  lenient.on_bad = [&](const std::string& problem) { complaints += problem; };
  const PairExamples source = examples(lenient);
  for (std::uint64_t n = 0; n < 40; ++n) EXPECT_FALSE(source.training(n).source.empty());
  EXPECT_NE(complaints.find("view_1.png"), std::string::npos);
}

}  // namespace
}  // namespace earpoint
