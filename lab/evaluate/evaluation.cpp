#include <earpoint/evaluate/evaluation.h>

#include <algorithm>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include <earpoint/core/parallel.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/metrics.h>
#include <earpoint/evaluate/speech_metrics.h>

namespace earpoint {
namespace {

/// What each thread has of its own.
struct Worker {
  std::vector<std::unique_ptr<Method>> methods;
  ClipMeasurer measurer;
  SpeakerTelling tell;  ///< empty: the truth
};

/// Mean over the ears.
std::optional<double> mean_si_sdr_db(const Waveform& clean, const Waveform& sound) {
  double sum = 0.0;
  for (int ear = 0; ear < clean.channels(); ++ear) {
    const std::optional<double> ratio = si_sdr_db(clean.channel(ear), sound.channel(ear));
    if (!ratio) return std::nullopt;
    sum += *ratio;
  }
  return sum / clean.channels();
}

/// SI-SDR of the source's separated and whole sound, in the window that is compared.
void measure_separation(const PairSample& sample, ClipResult& result) {
  if (!sample.clean || !sample.ambient) return;
  const PairSample window = without_context(sample);
  Waveform heard = window.source;
  for (std::size_t i = 0; i < heard.planar().size(); ++i) {
    heard.planar()[i] += window.ambient->planar()[i];
  }
  result.heard_si_sdr_db = mean_si_sdr_db(*window.clean, heard);
  result.primary_si_sdr_db = mean_si_sdr_db(*window.clean, window.source);
}

/// One pair of a batch while it is evaluated.
struct Clip {
  std::optional<std::string> problem;
  ClipResult result;
  Waveform target;
  std::optional<PairTruth> truth;
  std::vector<Waveform> renderings;  ///< by method, as the released evaluation would make them
};

class Evaluation {
 public:
  Evaluation(const EvaluationSet& set, std::span<const MethodEntry> methods,
             const EvaluationOptions& options)
      : set_(set), methods_(methods), options_(options), pool_(options.jobs) {
    for (int i = 0; i < options.jobs; ++i) {
      Worker worker{.methods = {},
                    .measurer = ClipMeasurer(options.make_estimator ? options.make_estimator()
                                                                    : ReverberationEstimator(),
                                             options.judges_speech),
                    .tell = options.make_telling ? options.make_telling() : SpeakerTelling()};
      for (const MethodEntry& entry : methods) worker.methods.push_back(entry.make());
      workers_.push_back(std::move(worker));
    }
    for (const MethodEntry& entry : methods) {
      result_.methods.push_back({entry.name, entry.what, entry.is_oracle, 0});
    }
  }

  EvaluationResult run(ProgressSink& progress) {
    progress.begin("evaluating", static_cast<double>(set_.size()), "clips");
    for (std::size_t start = 0; start < set_.size(); start += kReleasedBatch) {
      std::vector<Clip> batch(std::min(kReleasedBatch, set_.size() - start));
      pool_.run(std::ssize(batch), [&](std::ptrdiff_t i, int worker) {
        process(start + i, batch[i], workers_[worker]);
        progress.advance(1.0);
      });
      take_bad_out(batch);
      fix_signs(batch);
      for (Clip& clip : batch) result_.clips.push_back(std::move(clip.result));
    }
    progress.finish();
    if (result_.clips.empty()) throw InputError("the pair list", "no pair could be read");
    return std::move(result_);
  }

 private:
  void process(std::size_t pair, Clip& clip, Worker& worker) {
    clip.result.pair = pair;
    clip.result.name = set_.name(pair);
    clip.result.scene = set_.scene(pair);
    clip.result.cluster = set_.cluster(pair);
    clip.result.voice = set_.voice(pair);
    std::optional<PairSample> sample;
    try {
      sample = set_.sample(pair);
      clip.truth = set_.truth(pair);
      worker.measurer.set_target(sample->target, clip.truth ? &*clip.truth : nullptr);
    } catch (const InputError& error) {
      clip.problem = error.what();
      return;
    }
    clip.target = sample->target;
    clip.result.source_from_target = sample->source_from_target;
    if (set_.knows_speaker()) clip.result.speaker_m = sample->speaker_m;
    clip.result.speaker_in_sight = sample->speaker_box.has_value();
    measure_separation(*sample, clip.result);
    const std::optional<PairSample> released = set_.released_sample(pair);
    const PairSample told = as_told(*sample, worker);
    const PairSample released_told = released ? as_told(*released, worker) : PairSample();
    for (std::size_t m = 0; m < methods_.size(); ++m) {
      Waveform rendering = render(m, worker, *sample, told, clip);
      clip.result.honest.push_back(worker.measurer.measure(rendering));
      if (released) {
        rendering = render(m, worker, *released, released_told, clip);
        clip.result.released.push_back(worker.measurer.measure(rendering));
      } else {
        clip.result.released.push_back(clip.result.honest.back());
      }
      clip.renderings.push_back(std::move(rendering));
    }
  }

  /// What methods other than oracles are given.
  static PairSample as_told(PairSample sample, const Worker& worker) {
    sample.target = Waveform();
    if (worker.tell) worker.tell(sample);
    return sample;
  }

  /// Runs a method on what it may be given.
  Waveform render(std::size_t method, Worker& worker, const PairSample& sample,
                  const PairSample& told, const Clip& clip) const {
    const MethodEntry& entry = methods_[method];
    try {
      return ask(*worker.methods[method], entry, entry.is_oracle ? sample : told, clip.result.scene,
                 clip.truth ? &*clip.truth : nullptr);
    } catch (const InputError& error) {
      throw InputError("method " + entry.name, error.what());
    }
  }

  void take_bad_out(std::vector<Clip>& batch) {
    for (const Clip& clip : batch) {
      if (!clip.problem) continue;
      if (!options_.skip_bad) {
        throw InputError(clip.result.name, *clip.problem, "repair the data, or skip bad pairs");
      }
      result_.skipped.push_back({clip.result.name, *clip.problem});
    }
    std::erase_if(batch, [](const Clip& clip) { return clip.problem.has_value(); });
  }

  /// The released evaluation's sign fix, over the batch; changed renderings are measured again.
  void fix_signs(std::vector<Clip>& batch) {
    std::vector<Waveform> targets;
    targets.reserve(batch.size());
    for (const Clip& clip : batch) targets.push_back(clip.target);
    std::vector<std::size_t> changed;
    for (std::size_t m = 0; m < methods_.size(); ++m) {
      if (!methods_[m].fixes_sign) continue;
      std::vector<Waveform> renderings;
      renderings.reserve(batch.size());
      for (Clip& clip : batch) renderings.push_back(std::move(clip.renderings[m]));
      if (fix_sign(renderings, targets) != SignFix::none) {
        changed.push_back(m);
        ++result_.methods[m].sign_fixes;
      }
      for (std::size_t i = 0; i < batch.size(); ++i) {
        batch[i].renderings[m] = std::move(renderings[i]);
      }
    }
    if (changed.empty()) return;
    pool_.run(std::ssize(batch), [&](std::ptrdiff_t i, int worker) {
      ClipMeasurer& measurer = workers_[worker].measurer;
      measurer.set_target(batch[i].target, batch[i].truth ? &*batch[i].truth : nullptr);
      for (const std::size_t m : changed) {
        batch[i].result.released[m] = measurer.measure(batch[i].renderings[m]);
      }
    });
  }

  const EvaluationSet& set_;
  std::span<const MethodEntry> methods_;
  const EvaluationOptions& options_;
  ThreadPool pool_;
  std::vector<Worker> workers_;
  EvaluationResult result_;
};

}  // namespace

EvaluationResult evaluate(const EvaluationSet& set, std::span<const MethodEntry> methods,
                          const EvaluationOptions& options, ProgressSink& progress) {
  EARPOINT_CHECK(options.jobs > 0 && !methods.empty());
  for (const MethodEntry& entry : methods) {
    if (entry.needs_speaker && !set.knows_speaker()) {
      throw InputError("method " + entry.name,
                       "needs the speaker's position, which these "
                       "data do not have",
                       "leave it out");
    }
  }
  return Evaluation(set, methods, options).run(progress);
}

}  // namespace earpoint
