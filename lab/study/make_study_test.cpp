#include "test_study.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <earpoint/audio/loudness.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/metrics.h>
#include <earpoint/media/image_file.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

TEST(MakeStudy, FolderIsTheWholeStudy) {
  const TestFolder folder;
  const Study made = make_test_study(folder.path(), test_request(StudyDesign::choice));
  fs::rename(folder.path() / "study", folder.path() / "moved");
  fs::remove_all(folder.path() / "data");
  const Study read = read_study(folder.path() / "moved");
  EXPECT_EQ(text_of(read), text_of(made));
  EXPECT_EQ(read.clips.size(), 8U);  // 6 and 2 controls
  EXPECT_EQ(read.headphones.size(), kHeadphoneTrials);
  for (const StudyClip& clip : read.clips) {
    EXPECT_EQ(clip.sounds.size(), 3U) << clip.id;
    EXPECT_FALSE(read_image(folder.path() / "moved" / clip.picture).empty());
  }
}

TEST(MakeStudy, EveryClipIsFromAnotherConversation) {
  const TestFolder folder;
  const Study study = copy_test_study(folder.path(), StudyDesign::mushra);
  std::set<std::string> conversations;
  ASSERT_GT(study.clips.size(), 1U);
  for (const StudyClip& clip : study.clips) {
    EXPECT_TRUE(conversations.insert(clip.pair.substr(0, clip.pair.find(':'))).second) << clip.pair;
  }
}

TEST(MakeStudy, SameSeedSameBytesAndAnotherSeedOtherClips) {
  const TestFolder folder;
  StudyRequest request = test_request(StudyDesign::choice);
  const Study first = make_test_study(folder.path(), request);
  fs::rename(folder.path() / "study", folder.path() / "first");
  request.jobs = 2;
  make_test_study(folder.path(), request);
  for (const auto& entry : fs::recursive_directory_iterator(folder.path() / "first")) {
    if (!entry.is_regular_file()) continue;
    const fs::path file = fs::relative(entry.path(), folder.path() / "first");
    EXPECT_EQ(read_file(entry.path()), read_file(folder.path() / "study" / file)) << file;
  }
  fs::remove_all(folder.path() / "study");
  request.seed = 4;
  const Study other = make_test_study(folder.path(), request);
  const auto same =
      std::ranges::equal(first.clips, other.clips, {}, &StudyClip::pair, &StudyClip::pair);
  EXPECT_FALSE(same);
}

TEST(MakeStudy, SoundsOfAClipAreEquallyLoud) {
  const TestFolder folder;
  const Study study = copy_test_study(folder.path(), StudyDesign::mushra);
  ASSERT_FALSE(study.clips.empty());
  for (const StudyClip& clip : study.clips) {
    ASSERT_GT(clip.sounds.size(), 1U);
    const Waveform reference = read_sound(folder.path() / "study" / clip.reference);
    const double aim = loudness_lkfs(reference).value();
    EXPECT_LE(aim, kStudyLoudnessLkfs + 0.1) << clip.id;
    for (const StudySound& sound : clip.sounds) {
      const Waveform heard = read_sound(folder.path() / "study" / sound.file);
      // 16 bits at -26 LKFS: noise 70 dB below the sound.
      EXPECT_NEAR(loudness_lkfs(heard).value(), aim, 0.01) << clip.id << " " << sound.condition;
      EXPECT_NEAR(sound.mag, binaural_metrics(reference, heard).mag, 1e-3);
    }
  }
}

TEST(MakeStudy, KeptLoudnessKeepsWhatMethodsDid) {
  const TestFolder folder;
  StudyRequest request = test_request(StudyDesign::choice);
  request.match_loudness = false;
  const Study study = make_test_study(folder.path(), request);
  ASSERT_FALSE(study.clips.empty());
  for (const StudyClip& clip : study.clips) {
    ASSERT_GT(clip.sounds.size(), 1U);
    for (const StudySound& sound : clip.sounds) {
      EXPECT_DOUBLE_EQ(sound.gain_db, clip.sounds.front().gain_db);
    }
  }
}

TEST(MakeStudy, AnchorsAreTheReferenceInMonoAndWithExchangedEars) {
  const TestFolder folder;
  const Study study = copy_test_study(folder.path(), StudyDesign::mushra);
  const StudyClip& clip = study.clips.front();
  const auto heard = [&](std::string_view condition) {
    const auto sound = std::ranges::find(clip.sounds, condition, &StudySound::condition);
    return read_sound(folder.path() / "study" / sound->file);
  };
  const Waveform truth = heard(kTruthCondition);
  EXPECT_EQ(read_file(folder.path() / "study" / clip.reference),
            read_file(folder.path() / "study" / "clips" / clip.id / "truth.wav"));
  const Waveform swapped = heard(kSwappedCondition);
  const Waveform mono = heard(kMonoCondition);
  for (std::ptrdiff_t i = 0; i < truth.samples(); ++i) {
    // Loudness of the exchanged channels is the same up to rounding: one step of 16 bits.
    ASSERT_NEAR(swapped.channel(0)[i], truth.channel(1)[i], 3.1e-5);
    ASSERT_EQ(mono.channel(0)[i], mono.channel(1)[i]);
  }
}

TEST(MakeStudy, ControlsHoldTheReferenceAndNoDesignOfRatingsHasControls) {
  const TestFolder folder;
  const Study choice = copy_test_study(folder.path(), StudyDesign::choice);
  int controls = 0;
  for (const StudyClip& clip : choice.clips) {
    const bool has_truth =
        std::ranges::count(clip.sounds, kTruthCondition, &StudySound::condition) == 1;
    EXPECT_EQ(has_truth, clip.is_control) << clip.id;
    controls += clip.is_control ? 1 : 0;
  }
  EXPECT_EQ(controls, 2);
  fs::remove_all(folder.path() / "study");
  const Study mushra = copy_test_study(folder.path(), StudyDesign::mushra);
  EXPECT_EQ(mushra.clips.size(), 6U);
}

TEST(MakeStudy, TellsHeadphonesFromLoudspeakers) {
  const TestFolder folder;
  const Study study = copy_test_study(folder.path(), StudyDesign::choice);
  std::set<int> quietest;
  for (const HeadphoneTrial& trial : study.headphones) {
    const Waveform sound = read_sound(folder.path() / "study" / trial.file);
    double alone[3] = {};
    double summed[3] = {};
    for (int tone = 0; tone < 3; ++tone) {
      for (std::ptrdiff_t i = 0; i < 44100; ++i) {
        const double left = sound.channel(0)[tone * 66150 + i];
        const double both = 0.5 * (left + sound.channel(1)[tone * 66150 + i]);
        alone[tone] += left * left;
        summed[tone] += both * both;
      }
    }
    EXPECT_EQ(std::min_element(alone, alone + 3) - alone, trial.quietest);
    EXPECT_NE(std::min_element(summed, summed + 3) - summed, trial.quietest);
    // 6 dB, to 0.03 dB.
    EXPECT_NEAR(alone[trial.quietest] / *std::max_element(alone, alone + 3), 0.251, 0.002);
    quietest.insert(trial.quietest);
  }
  EXPECT_EQ(quietest.size(), 3U);
}

TEST(MakeStudy, RefusesAFolderInUseOraclesAndTooFewPairs) {
  const TestFolder folder;
  StudyRequest request = test_request(StudyDesign::choice);
  make_test_study(folder.path(), request);
  EXPECT_THROW(make_test_study(folder.path(), request), InputError);
  fs::remove_all(folder.path() / "study");
  request.count = 50;
  try {
    make_test_study(folder.path(), request);
    ADD_FAILURE() << "8 conversations of 3 viewpoints gave 50 clips";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("fewer clips"), std::string::npos) << error.what();
  }
  EXPECT_FALSE(fs::exists(folder.path() / "study"));
  const auto material =
      study_material(folder.path() / "data", DatasetLayout::soundspaces, "test", {}, 1.0);
  std::vector<MethodEntry> methods = test_methods();
  methods[1].is_oracle = true;
  SilentProgress progress;
  request.count = 2;
  EXPECT_THROW(make_study(*material, methods, request, folder.path() / "study", progress),
               InputError);
  methods[1].is_oracle = false;
  methods[1].name = "truth";
  EXPECT_THROW(make_study(*material, methods, request, folder.path() / "study", progress),
               InputError);
}

TEST(Study, RefusesFilesOutsideOfItsFolderAndMissingOnes) {
  const TestFolder folder;
  Study study = copy_test_study(folder.path(), StudyDesign::choice);
  const fs::path place = folder.path() / "study";
  const std::string good = study.clips[0].reference;
  for (const char* file : {"/etc/passwd", "../data/dataset.json", "clips/none.wav"}) {
    study.clips[0].reference = file;
    write_file(place / "study.json", text_of(study));
    EXPECT_THROW((void)read_study(place), InputError) << file;
  }
  study.clips[0].reference = good;
  write_file(place / "study.json", text_of(study));
  EXPECT_NO_THROW((void)read_study(place));
}

}  // namespace
}  // namespace earpoint
