#include <earpoint/evaluate/viewed_clip.h>

#include "report_sounds.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include <fmt/format.h>

#include <earpoint/dataset/pair_list.h>
#include <earpoint/dataset/replay_pair.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr std::size_t kCacheBytes = std::size_t{64} << 20U;

/// "home-100/3:2" is the clip "home-100/3" and the source "2".
struct AskedClip {
  explicit AskedClip(const std::string& words) : name(words) {
    if (const auto colon = words.rfind(':'); colon != std::string::npos) {
      name = words.substr(0, colon);
      source = words.substr(colon + 1);
    }
  }
  std::string name;
  std::optional<std::string> source;
};

[[noreturn]] void refuse(const std::string& words, const std::string& why) {
  throw InputError("clips " + words, why, "expected SCENE/CLIP or SCENE/CLIP:SOURCE");
}

std::optional<int> number_in(const std::string& word) {
  int number = 0;
  const char* const end = word.data() + word.size();
  const auto [rest, error] = std::from_chars(word.data(), end, number);
  if (error != std::errc{} || rest != end || number < 0) return std::nullopt;
  return number;
}

/// One of two equal channels.
Waveform one_channel(const Waveform& sound) {
  Waveform mono(1, sound.samples(), sound.sample_rate_hz());
  std::ranges::copy(sound.channel(0), mono.channel(0).begin());
  return mono;
}

/// All viewpoints but the source, or `most` of them spread evenly.
std::vector<int> other_views(std::size_t views, int source, std::size_t most) {
  std::vector<int> others;
  for (int view = 0; view < static_cast<int>(views); ++view) {
    if (view != source) others.push_back(view);
  }
  const std::size_t count = std::min(most, others.size());
  std::vector<int> chosen;
  for (std::size_t i = 0; i < count; ++i) chosen.push_back(others[i * others.size() / count]);
  return chosen;
}

class SoundSpacesViews {
 public:
  explicit SoundSpacesViews(const ViewedClipChoice& choice)
      : most_targets_(choice.most_targets),
        dataset_(soundspaces_options(choice.data, choice.split)),
        sampler_(dataset_, kCacheBytes),
        near_(dataset_, kCacheBytes, ResponseDelays::dropped, PairTarget::near_microphone) {
    pairs_ = frozen_or_drawn_pairs(dataset_, choice.data).pairs;
  }

  [[nodiscard]] ViewedClip named(const std::string& words) const {
    const AskedClip asked(words);
    std::optional<ViewPair> chosen;
    for (const ViewPair& pair : pairs_) {
      if (fmt::format("{}/{}", pair.scene, pair.clip) != asked.name) continue;
      if (!chosen || (!sees_speaker(*chosen) && sees_speaker(pair))) chosen = pair;
    }
    if (!chosen) refuse(words, "names no clip of the split");
    if (asked.source) {
      const auto source = number_in(*asked.source);
      if (!source || *source >= std::ssize(clip(*chosen).viewpoints)) {
        refuse(words, "has no such source");
      }
      chosen->choice.source = *source;
    }
    return read(*chosen);
  }

  [[nodiscard]] std::vector<ViewedClip> first(std::size_t count) const {
    std::vector<ViewedClip> clips;
    std::string last;
    for (const ViewPair& pair : pairs_) {
      const std::string name = fmt::format("{}/{}", pair.scene, pair.clip);
      if (clips.size() == count) break;
      if (name == last || !sees_speaker(pair)) continue;
      clips.push_back(read(pair));
      last = name;
    }
    if (clips.empty()) {
      throw InputError("figure", "the speaker is visible from no source of the split",
                       "name the clips");
    }
    return clips;
  }

 private:
  [[nodiscard]] const SoundSpacesClip& clip(const ViewPair& pair) const {
    return clip_of(pair, dataset_.clips(), "the pair list");
  }

  [[nodiscard]] std::vector<FigureBox> people(const ViewPair& pair, int view) const {
    const SoundSpacesClip& clip_seen = clip(pair);
    std::vector<FigureBox> seen;
    for (int person = 0; person < std::ssize(clip_seen.speakers); ++person) {
      const auto& boxes = clip_seen.viewpoints.at(static_cast<std::size_t>(view)).bboxes;
      const auto found = boxes.find(clip_seen.speakers[static_cast<std::size_t>(person)].id);
      if (found == boxes.end()) continue;
      if (const auto box = from_soundspaces_box(found->second)) {
        seen.push_back({*box, person == pair.choice.speaker});
      }
    }
    return seen;
  }

  [[nodiscard]] bool sees_speaker(const ViewPair& pair) const {
    return std::ranges::any_of(people(pair, pair.choice.source), &FigureBox::speaks);
  }

  [[nodiscard]] ViewedClip read(const ViewPair& pair) const {
    const SoundSpacesClip& from = clip(pair);
    SoundSpacesChoice choice = pair.choice;
    ViewedClip viewed;
    viewed.scene = pair.scene;
    viewed.source = {sampler_.picture(from, choice.source), people(pair, choice.source)};
    for (const int view : other_views(from.viewpoints.size(), choice.source, most_targets_)) {
      choice.target = view;
      viewed.targets.push_back({fmt::format("{}", view),
                                sampler_.sample(from, choice),
                                {sampler_.picture(from, view), people(pair, view)}});
    }
    if (viewed.targets.empty()) {
      throw InputError(fmt::format("{}/{}", pair.scene, pair.clip),
                       "has only one viewpoint; a figure needs a target");
    }
    const double rate_hz = viewed.targets.front().sample.source.sample_rate_hz();
    viewed.name = fmt::format("{}, clip {}, at {:.2f} s", pair.scene, pair.clip,
                              static_cast<double>(choice.window_start) / rate_hz);
    viewed.near_microphone = one_channel(near_.sample(from, choice).target);
    return viewed;
  }

  std::size_t most_targets_;
  SoundSpacesDataset dataset_;
  PairSampler sampler_;
  PairSampler near_;
  std::vector<ViewPair> pairs_;
};

class ReplayViews {
 public:
  explicit ReplayViews(const ViewedClipChoice& choice)
      : most_targets_(choice.most_targets),
        dataset_(replay_options(choice.data, choice.split)),
        choices_(dataset_.released_choices()) {}

  [[nodiscard]] ViewedClip named(const std::string& words) const {
    const AskedClip asked(words);
    const auto found = std::ranges::find_if(
        dataset_.clips(), [&](const ReplayClip& clip) { return name_of(clip) == asked.name; });
    if (found == dataset_.clips().end()) refuse(words, "names no clip of the split");
    if (!asked.source) return read(*found, drawn_source(*found));
    for (int i = 0; i < std::ssize(found->images); ++i) {
      if (camera_of(*found, i) == *asked.source) return read(*found, i);
    }
    refuse(words, "has no such source");
  }

  [[nodiscard]] std::vector<ViewedClip> first(std::size_t count) const {
    std::vector<ViewedClip> clips;
    for (const ReplayClip& clip : dataset_.clips()) {
      if (clips.size() == count) break;
      ViewedClip viewed = read(clip, drawn_source(clip));
      if (!viewed.source.people.empty()) clips.push_back(std::move(viewed));
    }
    if (clips.empty()) {
      throw InputError("figure", "the speaker is visible from no source of the split",
                       "name the clips");
    }
    return clips;
  }

 private:
  [[nodiscard]] int drawn_source(const ReplayClip& clip) const {
    return choices_[static_cast<std::size_t>(&clip - dataset_.clips().data())].source;
  }

  /// A view, read as the source of a pair: only sources have a picture and boxes.
  [[nodiscard]] SeenView seen(const ReplayClip& clip, int view, int other) const {
    const PairSample sample = replay_pair(dataset_, clip, {view, other}, false);
    SeenView result{sample.picture, {}};
    if (sample.speaker_box) result.people.push_back({*sample.speaker_box, true});
    return result;
  }

  [[nodiscard]] ViewedClip read(const ReplayClip& clip, int source) const {
    ViewedClip viewed;
    viewed.scene = clip.scene;
    viewed.name = name_of(clip);
    viewed.knows_speaker = clip.mouth_m.has_value();
    for (const int view : other_views(clip.images.size(), source, most_targets_)) {
      viewed.targets.push_back({camera_of(clip, view),
                                replay_pair(dataset_, clip, {source, view}, false),
                                seen(clip, view, source)});
    }
    if (viewed.targets.empty())
      throw InputError(clip.folder, "has only one viewpoint; a figure needs a target");
    const PairSample& sample = viewed.targets.front().sample;
    viewed.source = {sample.picture, {}};
    if (sample.speaker_box) viewed.source.people.push_back({*sample.speaker_box, true});
    viewed.near_microphone = dataset_.near_sound(clip);
    return viewed;
  }

  std::size_t most_targets_;
  ReplayDataset dataset_;
  std::vector<ReplayChoice> choices_;
};

template <typename Views>
std::vector<ViewedClip> read_from(const Views& views, const ViewedClipChoice& choice) {
  if (choice.names.empty()) return views.first(choice.count);
  std::vector<ViewedClip> clips;
  for (const std::string& name : choice.names) clips.push_back(views.named(name));
  return clips;
}

FigureView picture_of(const std::string& title, const SeenView& seen) {
  FigureView view;
  view.title = title;
  if (seen.picture) view.picture = *seen.picture;
  view.boxes = seen.people;
  return view;
}

}  // namespace

std::vector<ViewedClip> read_viewed_clips(const ViewedClipChoice& choice) {
  EARPOINT_CHECK(choice.count > 0 && choice.most_targets > 0);
  if (choice.layout == DatasetLayout::replay) return read_from(ReplayViews(choice), choice);
  return read_from(SoundSpacesViews(choice), choice);
}

FigureRow figure_row(const ViewedClip& clip, std::span<const MethodEntry> methods,
                     const MethodEntry* enhancer) {
  FigureRow row{.title = clip.name, .views = {}};
  row.views.push_back(picture_of("Source", clip.source));
  row.views.back().sounds.push_back({"recorded", clip.targets.front().sample.source});
  int number = 0;
  for (const ViewedClip::Target& target : clip.targets) {
    FigureView view = picture_of(fmt::format("Target {}", ++number), target.seen);
    view.caption = words_of(target.sample.source_from_target);
    view.source_from_target = target.sample.source_from_target;
    for (const MethodEntry& method : methods) {
      EARPOINT_CHECK(!method.is_oracle);
      view.sounds.push_back(
          {method.name, ask(*method.make(), method, target.sample, clip.scene, nullptr)});
    }
    view.sounds.push_back({"truth", target.sample.target});
    row.views.push_back(std::move(view));
  }
  if (enhancer == nullptr) return row;
  // As in training, the microphone's position is not given.
  PairSample sample = clip.targets.front().sample;
  sample.source_from_target = {};
  FigureView voice;
  voice.title = "Enhancement";
  voice.has_own_scale = true;
  const auto speaker = std::ranges::find_if(clip.source.people, &FigureBox::speaks);
  if (clip.source.picture && speaker != clip.source.people.end()) {
    voice.picture = cut_out(*clip.source.picture, speaker->box);
  }
  voice.sounds.push_back(
      {"enhanced from the source",
       one_channel(ask(*enhancer->make(), *enhancer, sample, clip.scene, nullptr))});
  if (clip.near_microphone) {
    voice.sounds.push_back({"truth, at the speaker's microphone", *clip.near_microphone});
  }
  row.views.push_back(std::move(voice));
  return row;
}

}  // namespace earpoint
