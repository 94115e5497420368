#include <earpoint/generate/generation.h>

#include "conversation_folder.h"
#include "dataset_lock.h"
#include "dataset_record.h"
#include "speech_writer.h"

#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <utility>

#include <fmt/format.h>

#include <earpoint/audio/resample.h>
#include <earpoint/core/file.h>
#include <earpoint/core/parallel.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// Keys of the random streams of a conversation: a draw from one does not shift the others.
enum StreamKey : std::uint64_t { kPlanKey = 1, kVoiceKey, kTraceKey };

/// Scenes in use: made for the first of their conversations, released after the last.
class SceneShelf {
 public:
  SceneShelf(const SceneMaker& source, const std::vector<WorkItem>& items) : source_(source) {
    for (const WorkItem& item : items) ++slots_[item.scene].users;
  }

  std::shared_ptr<const PreparedScene> take(int scene) {
    Slot& slot = slots_.at(scene);
    // A second thread waits until the scene is made.
    const std::lock_guard lock(slot.mutex);
    if (!slot.scene) slot.scene = source_.make(scene);
    return slot.scene;
  }

  void give_back(int scene) {
    Slot& slot = slots_.at(scene);
    const std::lock_guard lock(slot.mutex);
    if (--slot.users == 0) slot.scene.reset();
  }

 private:
  struct Slot {
    std::mutex mutex;
    std::shared_ptr<const PreparedScene> scene;
    int users = 0;
  };

  const SceneMaker& source_;
  std::map<int, Slot> slots_;
};

/// Makes conversations, from many threads at once.
class Generator {
 public:
  Generator(const GenerationOptions& options, const SceneMaker& scenes,
            const FigureLibrary& figures, const SpeechCorpus& corpus,
            const std::vector<WorkItem>& items)
      : options_(options),
        scenes_(scenes),
        figures_(figures),
        corpus_(corpus),
        shelf_(scenes, items),
        simulator_(options.quality),
        speech_(options.folder / speech_folder_of(options.speech_form), options.speech_form) {}

  void make(const WorkItem& item, StageClock& clock) {
    const std::shared_ptr<const PreparedScene> scene = shelf_.take(item.scene);
    clock.charge(Stage::scene);
    RandomStream plan_random = stream(item, kPlanKey);
    const ConversationPlan plan =
        plan_conversation(scene->floor, scene->caster, figures_,
                          item.voices == DataSplit::test ? FigureSplit::test : FigureSplit::train,
                          options_.conversation, scene->name, plan_random);
    clock.charge(Stage::plan);
    RandomStream voice_random = stream(item, kVoiceKey);
    ConversationReport report;
    std::vector<std::string> ids;
    std::vector<Waveform> speeches;
    for (const PlannedPerson& person : plan.people) {
      const SpeechDraw draw = corpus_.draw(person.figure->gender, item.voices, voice_random);
      ids.push_back(draw.recording->id);
      report.voices.push_back(draw.speaker->name);
      speeches.push_back(speech_.write(item.split, *draw.recording));
      report.speech_s.push_back(speeches.back().duration_s());
    }
    clock.charge(Stage::speech);
    SimulatedConversation conversation =
        simulator_.simulate(*scene, plan, stream(item, kTraceKey).next(), clock);
    complete(report, conversation);
    if (options_.write_heard) speak(speeches, conversation);
    write_conversation(options_.folder, item, scenes_.name(item.scene), options_.path_prefix,
                       conversation, ids, report);
    shelf_.give_back(item.scene);
    clock.charge(Stage::writing);
  }

 private:
  [[nodiscard]] RandomStream stream(const WorkItem& item, StreamKey key) const {
    return {options_.seed,
            {static_cast<std::uint64_t>(item.scene), static_cast<std::uint64_t>(item.conversation),
             key}};
  }

  static void speak(const std::vector<Waveform>& speeches, SimulatedConversation& conversation) {
    for (SimulatedViewpoint& viewpoint : conversation.viewpoints) {
      for (std::size_t i = 0; i < speeches.size(); ++i) {
        const Waveform& response = viewpoint.responses[i];
        viewpoint.heard[i] =
            heard_speech(resample(speeches[i], response.sample_rate_hz()), response);
      }
    }
  }

  static void complete(ConversationReport& report, const SimulatedConversation& conversation) {
    report.escape_fraction.assign(conversation.escape_fractions.begin(),
                                  conversation.escape_fractions.end());
    report.reverberation_s = conversation.reverberation_s;
    report.viewpoints = static_cast<int>(conversation.viewpoints.size());
    for (const SimulatedViewpoint& viewpoint : conversation.viewpoints) {
      for (const auto& box : viewpoint.boxes) report.hidden += box ? 0 : 1;
    }
  }

  const GenerationOptions& options_;
  const SceneMaker& scenes_;
  const FigureLibrary& figures_;
  const SpeechCorpus& corpus_;
  SceneShelf shelf_;
  ConversationSimulator simulator_;
  SpeechWriter speech_;
};

/// Makes the conversations that are not stored yet.
/// @return the processor time by stage
StageClock make_conversations(const GenerationOptions& options, const SceneMaker& scenes,
                              const FigureLibrary& figures, const SpeechCorpus& corpus,
                              const std::vector<WorkItem>& items, ProgressSink& progress) {
  Generator generator(options, scenes, figures, corpus, items);
  std::vector<StageClock> clocks(static_cast<std::size_t>(options.jobs));
  ThreadPool pool(options.jobs);
  progress.begin("simulating", static_cast<double>(items.size()), "conversations");
  pool.run(std::ssize(items), [&](std::ptrdiff_t task, int worker) {
    StageClock clock;
    generator.make(items[static_cast<std::size_t>(task)], clock);
    clocks[static_cast<std::size_t>(worker)].add(clock);
    progress.advance(1.0);
  });
  progress.finish();
  StageClock total;
  for (const StageClock& clock : clocks) total.add(clock);
  return total;
}

}  // namespace

std::string_view speech_folder_of(SpeechForm form) {
  return form == SpeechForm::flac ? "speech" : "LibriSpeech-wav";
}

GenerationSummary generate_dataset(const GenerationOptions& options, const SceneMaker& scenes,
                                   const FigureLibrary& figures, const SpeechCorpus& corpus,
                                   ProgressSink& progress) {
  EARPOINT_CHECK(options.jobs > 0);
  const auto start = std::chrono::steady_clock::now();
  const std::vector<WorkItem> items = plan_work(options.order);
  const std::vector<WorkItem> mine = items_of_shard(items, options.order, options.shard);
  DatasetLock lock(options.folder, options.order);
  {
    const std::lock_guard guard(lock);
    begin_dataset(options, scenes, corpus, lock.others_work());
    lock.take(mine);
  }
  std::vector<WorkItem> to_do;
  for (const WorkItem& item : mine) {
    const std::string scene = scenes.name(item.scene);
    if (!stored_conversation(options.folder, item, scene, options.write_heard)) {
      to_do.push_back(item);
    }
  }
  GenerationSummary summary;
  if (!to_do.empty()) {
    summary.seconds = make_conversations(options, scenes, figures, corpus, to_do, progress);
  }
  summary.simulated = static_cast<int>(to_do.size());
  const std::lock_guard guard(lock);
  complete_dataset(options, scenes, corpus, items, lock.others_work(), summary);
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
  summary.wall_s = passed.count();
  return summary;
}

}  // namespace earpoint
