#include "pair_reader.h"

#include <span>
#include <utility>

#include <fmt/format.h>

#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/numpy_random.h>
#include <earpoint/dataset/pair_list.h>
#include <earpoint/dataset/replay.h>
#include <earpoint/dataset/replay_pair.h>
#include <earpoint/dataset/soundspaces.h>
#include <earpoint/error.h>
#include <earpoint/network/picture_planes.h>

namespace earpoint::python {
namespace {

namespace fs = std::filesystem;

/// Of filtered speech, responses and pictures; each process that reads keeps as much.
constexpr std::size_t kCache_bytes = std::size_t{256} << 20;

}  // namespace

/// The pairs of one layout.
class PairReader::Pairs {
 public:
  virtual ~Pairs() = default;
  [[nodiscard]] virtual std::size_t size() const = 0;
  [[nodiscard]] virtual DatasetLayout layout() const = 0;
  /// @param seed  of another pair; nothing: the one of that number
  [[nodiscard]] virtual PairItem item(std::size_t index,
                                      std::optional<std::uint64_t> seed) const = 0;
};

class PairReader::SoundSpacesPairs : public PairReader::Pairs {
 public:
  SoundSpacesPairs(const fs::path& folder, const PairOptions& options)
      : dataset_(soundspaces_options(folder, options.split)), sampler_(dataset_, kCache_bytes) {
    const bool is_frozen = options.draw == "frozen";
    list_ = is_frozen ? frozen_or_drawn_pairs(dataset_, folder)
                      : draw_pair_list(dataset_, draw_named(options.draw), options.seed);
    const fs::path where =
        is_frozen ? find_pair_list(folder, options.split).value_or(folder) : folder;
    for (const ViewPair& pair : list_.pairs) {
      clips_.push_back(&clip_of(pair, dataset_.clips(), where.string()));
    }
  }

  [[nodiscard]] std::size_t size() const override { return list_.pairs.size(); }
  [[nodiscard]] DatasetLayout layout() const override { return DatasetLayout::soundspaces; }

  [[nodiscard]] PairItem item(std::size_t index, std::optional<std::uint64_t> seed) const override {
    const SoundSpacesClip& clip = *clips_.at(index);
    const ViewPair pair = seed ? another(list_.pairs[index], clip, *seed) : list_.pairs[index];
    const SoundSpacesChoice& choice = pair.choice;
    PairItem item;
    item.name = fmt::format("{}, clip {}: {} -> {}, speaker {}, at {:.2f} s", pair.scene, pair.clip,
                            choice.source, choice.target, choice.speaker,
                            static_cast<double>(choice.window_start) / 16000.0);
    item.sample = sampler_.sample(clip, choice);
    return item;
  }

 private:
  [[nodiscard]] ViewPair another(const ViewPair& pair, const SoundSpacesClip& clip,
                                 std::uint64_t seed) const {
    const auto length = [&](const std::string& speech) { return dataset_.speech_samples(speech); };
    for (const ViewPair& drawn :
         draw_pair_list(list_.split, std::span(&clip, 1), length, seed).pairs) {
      if (drawn.choice.target == pair.choice.target) return drawn;
    }
    return pair;
  }

  SoundSpacesDataset dataset_;
  PairSampler sampler_;
  PairList list_;
  std::vector<const SoundSpacesClip*> clips_;
};

class PairReader::ReplayPairs : public PairReader::Pairs {
 public:
  ReplayPairs(const fs::path& folder, const PairOptions& options)
      : dataset_(replay_options(folder, options.split)),
        choices_(dataset_.released_choices()),
        align_(options.align) {
    if (options.draw != "frozen") (void)draw_named(options.draw);
  }

  [[nodiscard]] std::size_t size() const override { return choices_.size(); }
  [[nodiscard]] DatasetLayout layout() const override { return DatasetLayout::replay; }

  [[nodiscard]] PairItem item(std::size_t index, std::optional<std::uint64_t> seed) const override {
    ReplayChoice choice = choices_.at(index);
    const ReplayClip& clip = dataset_.clips()[index];
    if (seed) {
      NumpyRandom random(static_cast<std::uint32_t>(*seed));
      choice = dataset_.draw(clip, random);
    }
    PairItem item;
    item.name = fmt::format("{}: {} -> {}", name_of(clip), camera_of(clip, choice.source),
                            camera_of(clip, choice.target));
    item.sample = replay_pair(dataset_, clip, choice, align_);
    return item;
  }

 private:
  ReplayDataset dataset_;
  std::vector<ReplayChoice> choices_;
  bool align_;
};

PairReader::PairReader(const fs::path& folder, const PairOptions& options) {
  const std::optional<DatasetLayout> asked =
      options.layout ? std::optional(layout_named(*options.layout)) : std::nullopt;
  const DatasetLayout layout = dataset_layout(folder, asked);
  if (layout == DatasetLayout::rwavs) {
    throw InputError(folder.string(), "holds recordings of RWAVS, which are no pairs of viewpoints",
                     "give a data set in the layout soundspaces or replay");
  }
  const bool is_replay = layout == DatasetLayout::replay;
  pose_encoding_ = is_replay ? PoseEncoding::replay : PoseEncoding::soundspaces;
  box_encoding_ = is_replay ? BoxEncoding::corners : BoxEncoding::soundspaces;
  if (options.network) {
    const ViGasDescription network = vigas_description_from_json(*options.network, "network");
    pose_encoding_ = network.pose_encoding;
    box_encoding_ = network.box_encoding;
    encoder_ = network.image_encoder;
  }
  if (is_replay) {
    pairs_ = std::make_unique<ReplayPairs>(folder, options);
  } else {
    pairs_ = std::make_unique<SoundSpacesPairs>(folder, options);
  }
}

PairReader::~PairReader() = default;

std::size_t PairReader::size() const { return pairs_->size(); }

std::string PairReader::layout() const {
  return pairs_->layout() == DatasetLayout::replay ? "replay" : "soundspaces";
}

PairItem PairReader::item(std::size_t index) const {
  return finished(pairs_->item(index, std::nullopt));
}

PairItem PairReader::drawn(std::size_t index, std::uint64_t seed) const {
  return finished(pairs_->item(index, seed));
}

PairItem PairReader::finished(PairItem item) const {
  const PairSample& sample = item.sample;
  item.pose = encode_pose(pose_encoding_, sample.source_from_target, sample.world_from_source);
  item.box = encode_box(box_encoding_, sample.speaker_box);
  if (encoder_) {
    item.view = ImagePlanes{
        .channels = 3,
        .height = encoder_->height_px,
        .width = encoder_->width_px,
        .values = picture_planes(*sample.picture, encoder_->width_px, encoder_->height_px)};
  }
  return item;
}

}  // namespace earpoint::python
