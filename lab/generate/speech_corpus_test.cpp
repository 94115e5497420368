#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/generate/speech_corpus.h>
#include <earpoint/generate_testing/quick_generation.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class SpeechCorpusTest : public ::testing::Test {
 protected:
  void write_index(const std::string& text) const {
    write_file(folder_.path() / "speech.csv", text);
  }

  void write_recording(const std::string& name) const {
    fs::create_directories((folder_.path() / name).parent_path());
    write_file(folder_.path() / name, "not decoded when a corpus is loaded");
  }

  [[nodiscard]] std::string error_of(const std::string& index) const {
    write_index(index);
    try {
      static_cast<void>(SpeechCorpus::load(folder_.path()));
    } catch (const InputError& error) {
      const std::string message = error.what();
      return message.substr(message.find("speech.csv"));
    }
    return "none";
  }

  TestFolder folder_{"speech_corpus_test"};
};

TEST_F(SpeechCorpusTest, AnIndexGivesSpeakersSortedAndSplit) {
  write_test_corpus(folder_.path());
  const SpeechCorpus corpus = SpeechCorpus::load(folder_.path());
  ASSERT_EQ(corpus.speakers().size(), 6U);
  std::map<std::pair<Gender, DataSplit>, int> count;
  for (const SpeechSpeaker& speaker : corpus.speakers()) {
    ++count[{speaker.gender, speaker.split}];
    EXPECT_EQ(speaker.recordings.size(), 2U);
    EXPECT_EQ(&corpus.recording(speaker.recordings[1].id), &speaker.recordings[1]);
  }
  // Three of each gender: one for each split.
  EXPECT_EQ(count.size(), 6U);
}

TEST_F(SpeechCorpusTest, DrawsHaveTheGenderAndSplitThatWereAskedFor) {
  write_test_corpus(folder_.path());
  const SpeechCorpus corpus = SpeechCorpus::load(folder_.path());
  RandomStream random(1);
  for (int i = 0; i < 20; ++i) {
    const SpeechDraw draw = corpus.draw(Gender::male, DataSplit::val, random);
    EXPECT_EQ(draw.speaker->gender, Gender::male);
    EXPECT_EQ(draw.speaker->split, DataSplit::val);
  }
}

TEST_F(SpeechCorpusTest, SplitsOfTheIndexAreKept) {
  for (const char* name : {"a.wav", "b.wav"}) write_recording(name);
  write_index("file,speaker,gender,split\na.wav,\"Ann, the first\",F,test\nb.wav,Bob,M,train\n");
  const SpeechCorpus corpus = SpeechCorpus::load(folder_.path());
  ASSERT_EQ(corpus.speakers().size(), 2U);
  EXPECT_EQ(corpus.speakers()[0].name, "Ann, the first");
  EXPECT_EQ(corpus.speakers()[0].split, DataSplit::test);
  EXPECT_EQ(corpus.speakers()[0].recordings[0].id, "Ann__the_first-0-00000");
  RandomStream random(1);
  EXPECT_THROW(static_cast<void>(corpus.draw(Gender::male, DataSplit::test, random)), InputError);
}

TEST_F(SpeechCorpusTest, ErrorsNameTheLine) {
  write_recording("a.wav");
  EXPECT_EQ(error_of("file,who\n"),
            "speech.csv, line 1: expected the columns file,speaker,gender[,split]");
  EXPECT_EQ(error_of("file,speaker,gender\na.wav,Ann,x\n"),
            "speech.csv, line 2: expected female or male, found 'x'");
  EXPECT_EQ(error_of("file,speaker,gender\nb.wav,Ann,F\n"),
            "speech.csv, line 2: 'b.wav' does not exist");
  EXPECT_EQ(error_of("file,speaker,gender\na.wav,Ann\n"),
            "speech.csv, line 2: expected 3 cells, found 2");
  EXPECT_EQ(error_of("file,speaker,gender\na.wav,Ann,F\na.wav,Ann,M\n"),
            "speech.csv, line 3: the speaker 'Ann' had another gender or split before");
}

TEST_F(SpeechCorpusTest, LibriSpeechIsReadWithItsSubsets) {
  write_recording("train-clean-360/14/208/14-208-0001.flac");
  write_recording("train-clean-360/14/208/14-208-0000.flac");
  write_recording("train-clean-360/14/208/14-208.trans.txt");
  write_recording("dev-clean/84/121123/84-121123-0000.flac");
  write_file(folder_.path() / "SPEAKERS.TXT",
             "; comment\n14   | F | train-clean-360  | 25.03 | Kristin LeMoine\n"
             "84   | M | dev-clean        |  8.00 | Christie Nowak\n"
             "61   | M | test-clean       |  8.00 | Paul-Gabriel Wiener\n");
  const SpeechCorpus corpus = SpeechCorpus::load(folder_.path());
  ASSERT_EQ(corpus.speakers().size(), 2U);
  EXPECT_EQ(corpus.speakers()[0].gender, Gender::female);
  EXPECT_EQ(corpus.speakers()[0].split, DataSplit::train);
  ASSERT_EQ(corpus.speakers()[0].recordings.size(), 2U);
  EXPECT_EQ(corpus.speakers()[0].recordings[0].id, "14-208-0000");
  EXPECT_EQ(corpus.speakers()[1].split, DataSplit::val);
}

/// A second of a sine between two silences.
Waveform tone_between_silences(float amplitude, int sample_rate_hz) {
  Waveform sound(1, 3 * sample_rate_hz, sample_rate_hz);
  for (int i = sample_rate_hz; i < 2 * sample_rate_hz; ++i) {
    sound.channel(0)[i] =
        amplitude * static_cast<float>(std::sin(2.0 * kPi * 500.0 * i / sample_rate_hz));
  }
  return sound;
}

TEST(PrepareSpeech, SilenceIsCutAndTheLevelSet) {
  for (const float amplitude : {0.5F, 0.001F}) {
    const Waveform speech = prepare_speech(tone_between_silences(amplitude, 44100), "tone");
    EXPECT_EQ(speech.sample_rate_hz(), 16000);
    // A second and a tenth on either side, to within a frame of 20 ms at each end.
    EXPECT_NEAR(speech.duration_s(), 1.2, 0.04);
    double energy = 0.0;
    for (const float sample : speech.channel(0)) energy += static_cast<double>(sample) * sample;
    // -26 dB over the second of sound; the frames at its ends count only in part: 0.2 dB.
    EXPECT_NEAR(10.0 * std::log10(energy / 16000.0), -26.0, 0.2);
  }
}

TEST(PrepareSpeech, SilenceAndClicksAreRefused) {
  EXPECT_THROW(static_cast<void>(prepare_speech(Waveform(1, 16000, 16000), "silence")), InputError);
  Waveform click(1, 16000, 16000);
  click.channel(0)[8000] = 1.0F;
  EXPECT_THROW(static_cast<void>(prepare_speech(click, "click")), InputError);
}

}  // namespace
}  // namespace earpoint
