#include <earpoint/dataset/pair_list.h>

#include <algorithm>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/json_field.h>
#include <earpoint/core/json_file.h>
#include <earpoint/core/name_number.h>
#include <earpoint/core/random.h>
#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/numpy_random.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr const char* kFormat = "earpoint-pairs-1";
constexpr std::ptrdiff_t kWindow = 16000;
// The one worker of the released test's loader seeds its generator with its number.
constexpr std::uint32_t kReleasedSeed = 0;

ViewPair draw_pair(const SoundSpacesClip& clip, int target, const std::vector<int>& speakers,
                   const std::function<std::ptrdiff_t(const std::string&)>& speech_samples,
                   RandomStream& random) {
  ViewPair pair{.scene = clip.scene, .clip = clip.index, .choice = {}};
  pair.choice.target = target;
  pair.choice.source = static_cast<int>(random.index(clip.viewpoints.size() - 1));
  if (pair.choice.source >= target) ++pair.choice.source;
  pair.choice.speaker = speakers[random.index(speakers.size())];
  const std::ptrdiff_t spare = speech_samples(*clip.speakers[pair.choice.speaker].speech) - kWindow;
  if (spare > 0) {
    pair.choice.window_start =
        static_cast<std::ptrdiff_t>(random.index(static_cast<std::uint64_t>(spare) + 1));
  }
  return pair;
}

ViewPair parse_pair(const JsonField& json) {
  ViewPair pair{
      .scene = json.field("scene").text(), .clip = json.field("clip").integer(), .choice = {}};
  pair.choice.source = json.field("source").integer();
  pair.choice.target = json.field("target").integer();
  pair.choice.speaker = json.field("speaker").integer();
  pair.choice.window_start = json.field("window_start").integer();
  if (pair.choice.source == pair.choice.target || pair.choice.window_start < 0) {
    throw InputError(json.where(),
                     "expected two viewpoints and a window that starts at 0 or later");
  }
  return pair;
}

}  // namespace

PairList draw_pair_list(const std::string& split, std::span<const SoundSpacesClip> clips,
                        const std::function<std::ptrdiff_t(const std::string&)>& speech_samples,
                        std::uint64_t seed) {
  PairList list{.split = split, .pairs = {}};
  for (const SoundSpacesClip& clip : clips) {
    RandomStream random(seed, {name_number(clip.scene), static_cast<std::uint64_t>(clip.index)});
    std::vector<int> speakers;
    for (std::size_t i = 0; i < clip.speakers.size(); ++i) {
      if (clip.speakers[i].speech) speakers.push_back(static_cast<int>(i));
    }
    if (speakers.empty() || clip.viewpoints.size() < 2) continue;
    for (std::size_t target = 0; target < clip.viewpoints.size(); ++target) {
      list.pairs.push_back(
          draw_pair(clip, static_cast<int>(target), speakers, speech_samples, random));
    }
  }
  return list;
}

PairDraw draw_named(std::string_view name) {
  if (name == "every-target") return PairDraw::every_target;
  if (name == "released") return PairDraw::released;
  throw InputError("draw", fmt::format("expected every-target or released, found {}", name));
}

PairList draw_pair_list(const SoundSpacesDataset& dataset, PairDraw draw, std::uint64_t seed) {
  PairList list{.split = dataset.split(), .pairs = {}};
  if (draw == PairDraw::released) {
    NumpyRandom random(kReleasedSeed);
    for (const SoundSpacesClip& clip : dataset.clips()) {
      list.pairs.push_back(
          {.scene = clip.scene, .clip = clip.index, .choice = dataset.draw(clip, random)});
    }
    return list;
  }
  std::map<std::string, std::ptrdiff_t> known;
  const auto length = [&](const std::string& speech) {
    const auto [found, is_new] = known.try_emplace(speech, 0);
    try {
      if (is_new) found->second = dataset.speech_samples(speech);
    } catch (const InputError&) {
      // Left at zero: the first second.
    }
    return found->second;
  };
  list = draw_pair_list(dataset.split(), dataset.clips(), length, seed);
  if (list.pairs.empty()) {
    throw InputError("the split " + dataset.split(), "no clip has two viewpoints and speech");
  }
  return list;
}

std::optional<std::filesystem::path> find_pair_list(const std::filesystem::path& folder,
                                                    const std::string& split) {
  const std::string name = fmt::format("pairs-{}.json", split);
  const SoundSpacesDataset::Options options = soundspaces_options(folder, split);
  for (const std::filesystem::path& path : {folder / name, options.root / options.folder / name}) {
    if (std::filesystem::exists(path)) return path;
  }
  return std::nullopt;
}

PairList frozen_or_drawn_pairs(const SoundSpacesDataset& dataset,
                               const std::filesystem::path& folder) {
  if (const auto list = find_pair_list(folder, dataset.split())) return read_pair_list(*list);
  return draw_pair_list(dataset, PairDraw::every_target, kPairDrawSeed);
}

std::string text_of(const PairList& list) {
  std::string text = fmt::format("{{\n \"format\": {},\n \"split\": {},\n \"pairs\": [",
                                 nlohmann::json(kFormat).dump(), nlohmann::json(list.split).dump());
  const char* separator = "\n";
  for (const ViewPair& pair : list.pairs) {
    nlohmann::ordered_json json;
    json["scene"] = pair.scene;
    json["clip"] = pair.clip;
    json["source"] = pair.choice.source;
    json["target"] = pair.choice.target;
    json["speaker"] = pair.choice.speaker;
    json["window_start"] = pair.choice.window_start;
    text += separator + ("  " + json.dump());
    separator = ",\n";
  }
  return text + "\n ]\n}\n";
}

PairList read_pair_list(const std::filesystem::path& path) {
  const nlohmann::json document = read_json(path);
  const JsonField json(document, path.string());
  const std::string format = json.field("format").text();
  if (format != kFormat) {
    throw InputError(path.string(), fmt::format("expected format {}, found {}", kFormat, format));
  }
  PairList list{.split = json.field("split").text(), .pairs = {}};
  for (const JsonField& item : json.field("pairs").items()) list.pairs.push_back(parse_pair(item));
  return list;
}

const SoundSpacesClip& clip_of(const ViewPair& pair, std::span<const SoundSpacesClip> clips,
                               std::string_view where) {
  const auto found = std::find_if(clips.begin(), clips.end(), [&](const SoundSpacesClip& clip) {
    return clip.scene == pair.scene && clip.index == pair.clip;
  });
  if (found == clips.end()) {
    throw InputError(where,
                     fmt::format("the data set has no clip {} of scene {}", pair.clip, pair.scene));
  }
  const auto has = [](const auto& list, int index) {
    return index >= 0 && index < std::ssize(list);
  };
  if (!has(found->viewpoints, pair.choice.source) || !has(found->viewpoints, pair.choice.target) ||
      !has(found->speakers, pair.choice.speaker) || !found->speakers[pair.choice.speaker].speech) {
    throw InputError(where, fmt::format("clip {} of scene {} lacks a viewpoint or speaker of its "
                                        "pair",
                                        pair.clip, pair.scene));
  }
  return *found;
}

}  // namespace earpoint
