#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/dataset_testing/tiny_dataset.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/evaluation.h>
#include <earpoint/evaluate/metrics.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class EvaluationTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::path(testing::TempDir()) / ("evaluation." + std::to_string(::getpid()));
    fs::remove_all(folder_);
    // 12 clips of 3 viewpoints: more pairs than a batch of the released evaluation has.
    write_tiny_dataset(folder_, {.clips = 12});
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }

  static std::unique_ptr<EvaluationSet> test_set(std::optional<std::size_t> limit = {}) {
    return soundspaces_evaluation_set(folder_, "test", {}, limit, 10 << 20);
  }
  static EvaluationResult evaluate_all(const EvaluationSet& set,
                                       const std::vector<MethodEntry>& methods, int jobs = 2,
                                       bool skip_bad = false) {
    SilentProgress silent;
    EvaluationOptions options;
    options.jobs = jobs;
    options.skip_bad = skip_bad;
    return evaluate(set, methods, options, silent);
  }

  inline static fs::path folder_;
};

/// A method that is a function.
class FunctionMethod : public Method {
 public:
  using Function = std::function<Waveform(const Question&)>;
  explicit FunctionMethod(Function function) : function_(std::move(function)) {}
  Waveform render(const Question& question) override { return function_(question); }

 private:
  Function function_;
};

MethodEntry method(const std::string& name, const FunctionMethod::Function& function,
                   bool is_oracle = false) {
  return {name, "", is_oracle, [function] { return std::make_unique<FunctionMethod>(function); }};
}

Waveform scaled(Waveform sound, float left, float right) {
  for (float& x : sound.channel(0)) x *= left;
  for (float& x : sound.channel(1)) x *= right;
  return sound;
}

TEST_F(EvaluationTest, OnlyMethodsThatHearContextAreShownItAndTheSameWindowIsCompared) {
  constexpr std::ptrdiff_t kContext = 4000;
  const auto set =
      soundspaces_evaluation_set(folder_, "test", {}, 3, 10 << 20, PairTarget::viewpoint, kContext);
  const auto expect_length = [](std::ptrdiff_t samples) {
    return [samples](const Question& question) {
      EXPECT_EQ(question.sample.source.samples(), samples);
      EXPECT_FALSE(question.sample.clean.has_value());
      return question.sample.source;
    };
  };
  MethodEntry hears = method("hears", expect_length(kContext + kPairSamples));
  hears.hears_context = true;
  const MethodEntry does_not = method("does not", expect_length(kPairSamples));
  const EvaluationResult result = evaluate_all(*set, {input_method(), hears, does_not});
  const EvaluationResult alone = evaluate_all(*test_set(3), {input_method()});
  ASSERT_EQ(result.clips.size(), alone.clips.size());
  for (std::size_t i = 0; i < result.clips.size(); ++i) {
    const std::vector<ClipMetrics>& found = result.clips[i].honest;
    EXPECT_EQ(found[1][Metric::mag], found[0][Metric::mag]);
    EXPECT_EQ(found[2][Metric::mag], found[0][Metric::mag]);
    // Source and target are convolved in float32 by transforms of another size.
    EXPECT_NEAR(found[0][Metric::mag].value(), alone.clips[i].honest[0][Metric::mag].value(), 1e-5);
  }
}

TEST_F(EvaluationTest, TheShippedDspAnswersAWindowTheSameWithSoundBefore) {
  constexpr std::ptrdiff_t kContext = 4000;
  const auto longer =
      soundspaces_evaluation_set(folder_, "test", {}, 1, 10 << 20, PairTarget::viewpoint, kContext);
  const MethodEntry dsp = dsp_method();
  const auto method = dsp.make();
  const Waveform alone = ask(*method, dsp, test_set(1)->sample(0), "", nullptr);
  const Waveform more = ask(*method, dsp, longer->sample(0), "", nullptr);
  ASSERT_EQ(more.samples(), alone.samples());
  // Fixed filters are linear and the fades of windows add up to one: after the filters' memory of
  // some 20 ms only rounding differs, of floats up to 0.3.
  for (int ear = 0; ear < 2; ++ear) {
    for (std::ptrdiff_t i = 1600; i < alone.samples(); ++i) {
      ASSERT_NEAR(more.channel(ear)[i], alone.channel(ear)[i], 1e-5) << i;
    }
  }
}

TEST_F(EvaluationTest, ClipsAreMeasuredInTheListsOrder) {
  const auto set = test_set();
  ASSERT_EQ(set->size(), 36U);
  const EvaluationResult result =
      evaluate_all(*set, {input_method(), method("double", [](const Question& question) {
                            return scaled(question.sample.source, 2.0F, 2.0F);
                          })});
  ASSERT_EQ(result.clips.size(), set->size());
  EXPECT_EQ(result.methods[1].name, "double");
  EXPECT_TRUE(result.skipped.empty());
  for (std::size_t pair = 0; pair < set->size(); ++pair) {
    const ClipResult& clip = result.clips[pair];
    const PairSample sample = set->sample(pair);
    EXPECT_EQ(clip.pair, pair);
    EXPECT_EQ(clip.cluster, static_cast<int>(pair / 3));
    EXPECT_EQ(clip.speaker_in_sight, sample.speaker_box.has_value());
    for (int m = 0; m < 2; ++m) {
      const float factor = m == 0 ? 1.0F : 2.0F;
      const BinauralMetrics expected =
          binaural_metrics(sample.target, scaled(sample.source, factor, factor));
      EXPECT_EQ(clip.honest[m][Metric::mag], expected.mag);
      EXPECT_EQ(clip.honest[m][Metric::lre], expected.lre_db);
      EXPECT_EQ(clip.honest[m][Metric::l2], expected.l2);
      EXPECT_TRUE(clip.honest[m][Metric::early_decay].has_value());
      EXPECT_FALSE(clip.honest[m][Metric::rte].has_value());
    }
  }
}

TEST_F(EvaluationTest, OnlyOraclesSeeTheTargetAndTheTruth) {
  const auto check = [](bool is_oracle) {
    return [is_oracle](const Question& question) {
      EXPECT_EQ(question.sample.target.empty(), !is_oracle);
      EXPECT_EQ(question.truth != nullptr, is_oracle);
      EXPECT_EQ(question.scene, "room");
      return question.sample.source;
    };
  };
  const auto set = test_set(4);
  (void)evaluate_all(*set, {method("blind", check(false)), method("oracle", check(true), true)});
}

TEST_F(EvaluationTest, TellsMethodsOfTheSpeakerWhatItIsAskedToAndOraclesTheTruth) {
  const auto set = test_set(3);
  const Box told{.x_min = 0.125, .y_min = 0.25, .x_max = 0.5, .y_max = 0.75};
  const auto check = [&](bool is_oracle) {
    return [&, is_oracle](const Question& question) {
      EXPECT_EQ(question.sample.speaker_box == told, !is_oracle);
      EXPECT_TRUE(is_oracle || question.sample.target.empty());
      return question.sample.source;
    };
  };
  EvaluationOptions options;
  options.make_telling = [told] {
    return [told](PairSample& sample) { sample.speaker_box = told; };
  };
  SilentProgress silent;
  const std::vector<MethodEntry> methods{method("told", check(false)),
                                         method("oracle", check(true), true)};
  const EvaluationResult result = evaluate(*set, methods, options, silent);
  ASSERT_EQ(result.clips.size(), 3U);
  for (const ClipResult& clip : result.clips) {
    EXPECT_EQ(clip.speaker_in_sight, set->sample(clip.pair).speaker_box.has_value());
  }
}

TEST_F(EvaluationTest, WithoutBoxesMethodsAreToldNothing) {
  const auto set = test_set(1);
  PairSample sample = set->sample(0);
  sample.speaker_box = Box{};
  telling_maker(SpeakerBoxes::none, std::nullopt)()(sample);
  EXPECT_FALSE(sample.speaker_box);
  EXPECT_EQ(sample.speaker_m, Vector3());
  EXPECT_FALSE(telling_maker(SpeakerBoxes::truth, std::nullopt));
  EXPECT_THROW((void)boxes_named("some"), InputError);
}

TEST_F(EvaluationTest, SignFixChangesOnlyTheReleasedColumn) {
  const auto set = test_set();
  const EvaluationResult result =
      evaluate_all(*set, {input_method(), method("opposite", [](const Question& question) {
                            return scaled(question.sample.source, 1.0F, -1.0F);
                          })});
  EXPECT_EQ(result.methods[0].sign_fixes, 0U);
  EXPECT_EQ(result.methods[1].sign_fixes, 2U);  // batches of 32 and 4
  for (const ClipResult& clip : result.clips) {
    // Metrics of magnitudes ignore the sign.
    EXPECT_EQ(clip.honest[1][Metric::mag], clip.honest[0][Metric::mag]);
    EXPECT_EQ(clip.honest[1][Metric::lre], clip.honest[0][Metric::lre]);
    EXPECT_NE(clip.honest[1][Metric::l2], clip.honest[0][Metric::l2]);
    for (const Metric metric : all_metrics()) {
      EXPECT_EQ(clip.released[1][metric], clip.honest[0][metric]) << name_of(metric).key;
      EXPECT_EQ(clip.released[0][metric], clip.honest[0][metric]) << name_of(metric).key;
    }
  }
}

/// A set whose released evaluation gives methods the target as source.
class CheatingSet : public EvaluationSet {
 public:
  explicit CheatingSet(const EvaluationSet& set) : set_(set) {}
  [[nodiscard]] std::size_t size() const override { return set_.size(); }
  [[nodiscard]] std::string name(std::size_t pair) const override { return set_.name(pair); }
  [[nodiscard]] std::string scene(std::size_t pair) const override { return set_.scene(pair); }
  [[nodiscard]] int cluster(std::size_t pair) const override { return set_.cluster(pair); }
  [[nodiscard]] std::string pairs() const override { return set_.pairs(); }
  [[nodiscard]] PairSample sample(std::size_t pair) const override { return set_.sample(pair); }
  [[nodiscard]] std::optional<PairTruth> truth(std::size_t /*pair*/) const override { return {}; }
  [[nodiscard]] std::optional<PairSample> released_sample(std::size_t pair) const override {
    PairSample sample = set_.sample(pair);
    sample.source = sample.target;
    return sample;
  }

 private:
  const EvaluationSet& set_;
};

TEST_F(EvaluationTest, SignFixLeavesTheInputAlone) {
  // An anti-phase target: the released synthesis would negate an ear of the source.
  class OppositeSet : public CheatingSet {
   public:
    using CheatingSet::CheatingSet;
    [[nodiscard]] PairSample sample(std::size_t pair) const override {
      PairSample sample = CheatingSet::sample(pair);
      sample.source = scaled(std::move(sample.source), 1.0F, -1.0F);
      return sample;
    }
    [[nodiscard]] std::optional<PairSample> released_sample(std::size_t /*pair*/) const override {
      return std::nullopt;
    }
  };
  const auto set = test_set(3);
  const EvaluationResult result =
      evaluate_all(OppositeSet(*set), {input_method(), network_method("copy", "input")});
  EXPECT_EQ(result.methods[0].sign_fixes, 0U);
  EXPECT_EQ(result.methods[1].sign_fixes, 1U);
  for (const ClipResult& clip : result.clips) {
    EXPECT_EQ(clip.released[0][Metric::l2], clip.honest[0][Metric::l2]);
    EXPECT_LT(clip.released[1][Metric::l2].value(), clip.honest[1][Metric::l2].value());
  }
}

TEST_F(EvaluationTest, ReleasedColumnTakesTheReleasedSample) {
  const auto set = test_set(3);
  const EvaluationResult result = evaluate_all(CheatingSet(*set), {input_method()});
  ASSERT_EQ(result.clips.size(), 3U);
  for (const ClipResult& clip : result.clips) {
    EXPECT_GT(clip.honest[0][Metric::mag], 0.0);
    EXPECT_EQ(clip.released[0][Metric::mag], 0.0);
    EXPECT_FALSE(clip.honest[0][Metric::early_decay].has_value());
  }
}

TEST_F(EvaluationTest, LimitIsSpreadOverConversations) {
  const auto set = test_set(12);
  ASSERT_EQ(set->size(), 12U);
  for (std::size_t pair = 0; pair < 12; ++pair)
    EXPECT_EQ(set->cluster(pair), static_cast<int>(pair));
}

TEST_F(EvaluationTest, BadPairsStopItUnlessSkipped) {
  const fs::path broken = folder_.string() + ".broken";
  fs::remove_all(broken);
  fs::copy(folder_, broken, fs::copy_options::recursive);
  fs::remove(broken / "test/room/5/rir_1_0.wav");
  fs::remove(broken / "test/room/5/rir_1_1.wav");
  const auto set = soundspaces_evaluation_set(broken, "test", {}, {}, 10 << 20);
  try {
    (void)evaluate_all(*set, {input_method()});
    FAIL() << "expected an InputError";
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("room, clip 5"), std::string::npos) << message;
    EXPECT_NE(message.find("rir_1_"), std::string::npos) << message;
    EXPECT_NE(message.find("skip bad pairs"), std::string::npos) << message;
  }
  const EvaluationResult result = evaluate_all(*set, {input_method()}, 2, true);
  EXPECT_EQ(result.clips.size() + result.skipped.size(), 36U);
  ASSERT_FALSE(result.skipped.empty());
  for (const BadPair& pair : result.skipped) {
    EXPECT_TRUE(pair.name.starts_with("room, clip 5")) << pair.name;
    EXPECT_NE(pair.problem.find("no such file"), std::string::npos) << pair.problem;
  }
  fs::remove_all(broken);
}

TEST_F(EvaluationTest, FailingMethodIsNamed) {
  const auto set = test_set(1);
  try {
    (void)evaluate_all(*set, {method("lazy", [](const Question&) -> Waveform {
      throw InputError("box", "is missing");
    })});
    FAIL() << "expected an InputError";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "method lazy: box: is missing");
  }
}

TEST_F(EvaluationTest, NetworkGetsTheWholeWindow) {
  // The copying synthesizer works in windows of a second, like the networks.
  const auto set = test_set(2);
  const EvaluationResult result =
      evaluate_all(*set, {input_method(), network_method("copy", "input")});
  ASSERT_EQ(result.clips.size(), 2U);
  for (const ClipResult& clip : result.clips) {
    EXPECT_GT(clip.honest[0][Metric::mag], 0.0);
    for (const Metric metric : all_metrics()) {
      EXPECT_EQ(clip.honest[0][metric], clip.honest[1][metric]) << name_of(metric).key;
    }
  }
}

TEST_F(EvaluationTest, PairsAreDrawnWhereTheDataHaveNoList) {
  const fs::path bare = folder_.string() + ".bare";
  fs::remove_all(bare);
  fs::copy(folder_, bare, fs::copy_options::recursive);
  fs::remove(bare / "pairs-test.json");
  const auto with_list = test_set();
  const auto drawn = soundspaces_evaluation_set(bare, "test", {}, {}, 10 << 20);
  EXPECT_EQ(with_list->pairs(), (folder_ / "pairs-test.json").string());
  EXPECT_NE(drawn->pairs().find("drawn, every viewpoint"), std::string::npos) << drawn->pairs();
  // The same draw as that of `simulate`, with the same seed.
  ASSERT_EQ(drawn->size(), with_list->size());
  for (std::size_t pair = 0; pair < drawn->size(); ++pair) {
    EXPECT_EQ(drawn->name(pair), with_list->name(pair));
  }
  const auto released =
      soundspaces_evaluation_set(bare, "test", {.draw = PairDraw::released}, {}, 10 << 20);
  EXPECT_EQ(released->size(), 12U);
  EXPECT_NE(released->pairs().find("as the released test"), std::string::npos);
  for (std::size_t pair = 0; pair < released->size(); ++pair) {
    EXPECT_NE(released->name(pair).find("at 0.00 s"), std::string::npos) << released->name(pair);
  }
  EXPECT_THROW((void)soundspaces_evaluation_set(bare, "test", {.list = bare / "none.json"}, {}, 0),
               InputError);
  fs::remove_all(bare);
}

TEST_F(EvaluationTest, PairListOfAnotherSplitIsRefused) {
  EXPECT_THROW((void)soundspaces_evaluation_set(folder_, "test",
                                                {.list = folder_ / "pairs-val.json"}, {}, 0),
               InputError);
}

}  // namespace
}  // namespace earpoint
