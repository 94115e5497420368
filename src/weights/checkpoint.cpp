#include <earpoint/weights/checkpoint.h>

#include "stored_tensor.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <earpoint/core/quote.h>
#include <earpoint/error.h>
#include <earpoint/weights/pickle.h>
#include <earpoint/weights/zip_archive.h>

namespace earpoint {
namespace {

using Kind = PickleValue::Kind;

constexpr std::uint64_t kLargestPickle = 64U << 20U;

/// Tensors may share storages, or repeat elements by a stride of 0, and then take more memory than
/// the file: at most this many times as much.
constexpr std::uint64_t kMostBytesPerFileByte = 4;

/// Keys and values, alternating, of a dict or of an object that behaves like one; nothing if the
/// value is neither.
std::optional<std::span<const PickleValue* const>> dictionary_items(const PickleValue& value) {
  if (value.kind == Kind::dict) return value.items;
  if (value.is_made_by("collections", "OrderedDict") && value.entries().size() % 2 == 0) {
    return value.entries();
  }
  return std::nullopt;
}

/// The options in a dict, or in the attributes of an argparse.Namespace or of Lightning's
/// AttributeDict.
std::optional<std::span<const PickleValue* const>> option_items(const PickleValue& value) {
  if (value.is_made_by("argparse", "Namespace")) return dictionary_items(value.state());
  for (const char* module :
       {"pytorch_lightning.utilities.parsing", "lightning.pytorch.utilities.parsing",
        "lightning_fabric.utilities.data", "lightning.fabric.utilities.data"}) {
    if (value.is_made_by(module, "AttributeDict") && value.entries().size() % 2 == 0) {
      return value.entries();
    }
  }
  return dictionary_items(value);
}

/// The value of that key; null if there is none.
const PickleValue* find(std::span<const PickleValue* const> items, std::string_view key) {
  for (std::size_t i = 0; i + 1 < items.size(); i += 2) {
    if (items[i]->kind == Kind::string && items[i]->text == key) return items[i + 1];
  }
  return nullptr;
}

/// "best_val/" for "best_val/data.pkl": the folder is named after the file at the time of saving.
std::string archive_folder(const ZipArchive& archive, std::string_view where) {
  std::optional<std::string> folder;
  for (const auto& [name, size] : archive.sizes()) {
    constexpr std::string_view kPickle = "data.pkl";
    if (!name.ends_with(kPickle)) continue;
    const std::string before = name.substr(0, name.size() - kPickle.size());
    // One folder at most: deeper ones hold other things.
    if (!before.empty() && before.find('/') != before.size() - 1) continue;
    if (folder) throw InputError(where, "has more than one data.pkl");
    folder = before;
  }
  if (!folder) {
    throw InputError(where, "is a zip archive without a data.pkl",
                     "is it a checkpoint that torch.save wrote?");
  }
  return *folder;
}

std::map<std::string, HyperParameter> read_options(const PickleValue& value,
                                                   std::string_view where) {
  const auto items = option_items(value);
  if (!items) throw InputError(where, "hparams are neither a dictionary nor an argparse.Namespace");
  std::map<std::string, HyperParameter> options;
  for (std::size_t i = 0; i + 1 < items->size(); i += 2) {
    const PickleValue& key = *(*items)[i];
    const PickleValue& option = *(*items)[i + 1];
    if (key.kind != Kind::string) throw InputError(where, "hparams: a name is not a string");
    HyperParameter kept;
    switch (option.kind) {
      case Kind::boolean:
        kept = option.boolean;
        break;
      case Kind::integer:
        kept = option.integer;
        break;
      case Kind::real:
        kept = option.real;
        break;
      case Kind::string:
        kept = std::string(option.text);
        break;
      default:
        continue;
    }
    if (!options.emplace(key.text, std::move(kept)).second) {
      throw InputError(where, fmt::format("hparams: {} occurs twice", in_quotes(key.text)));
    }
  }
  return options;
}

std::map<std::string, StoredTensor> read_state_dict(std::span<const PickleValue* const> items,
                                                    std::string_view where) {
  std::map<std::string, StoredTensor> tensors;
  for (std::size_t i = 0; i + 1 < items.size(); i += 2) {
    const PickleValue& name = *items[i];
    if (name.kind != Kind::string) throw InputError(where, "a tensor's name is not a string");
    const std::string here = fmt::format("{}: tensor {}", where, in_quotes(name.text));
    if (!tensors.emplace(name.text, stored_tensor_from(*items[i + 1], here)).second) {
      throw InputError(here, "occurs twice");
    }
  }
  return tensors;
}

/// The dictionary of weights in the top value: named, or the top value itself.
std::span<const PickleValue* const> find_state_dict(const PickleValue& top,
                                                    std::string_view where) {
  const auto items = dictionary_items(top);
  if (!items) throw InputError(where, "its pickle is not a dictionary");
  for (const char* key : {"state_dict", "predictor"}) {
    const PickleValue* found = find(*items, key);
    if (found == nullptr) continue;
    const auto weights = dictionary_items(*found);
    if (!weights) throw InputError(where, fmt::format("'{}' is not a dictionary", key));
    return *weights;
  }
  const bool of_tensors =
      items->size() >= 2 && (*items)[1]->is_made_by("torch._utils", "_rebuild_tensor_v2");
  if (!of_tensors) throw InputError(where, "has neither 'state_dict' nor 'predictor'");
  return *items;
}

/// Reads each storage once, however many tensors share it.
std::map<std::string, Tensor> load_tensors(const std::map<std::string, StoredTensor>& stored,
                                           const ZipArchive& archive, const std::string& folder,
                                           std::string_view where) {
  std::uint64_t total = 0;
  std::map<std::string_view, std::vector<const std::pair<const std::string, StoredTensor>*>>
      by_storage;
  for (const auto& entry : stored) {
    const std::string here = fmt::format("{}: tensor {}", where, in_quotes(entry.first));
    if (__builtin_add_overflow(total, entry.second.size_bytes(), &total) ||
        total / kMostBytesPerFileByte > archive.file_size()) {
      throw InputError(here, fmt::format("the tensors together would be more than {} times as "
                                         "large as the file",
                                         kMostBytesPerFileByte));
    }
    by_storage[entry.second.storage_key].push_back(&entry);
  }

  std::map<std::string, Tensor> tensors;
  for (const auto& [key, users] : by_storage) {
    const std::string member = fmt::format("{}data/{}", folder, key);
    if (!archive.contains(member)) {
      throw InputError(fmt::format("{}: tensor {}", where, in_quotes(users[0]->first)),
                       fmt::format("its storage {} is not in the archive", in_quotes(member)));
    }
    const std::vector<std::byte> storage = archive.read(member);
    for (const auto* user : users) {
      const std::string here = fmt::format("{}: tensor {}", where, in_quotes(user->first));
      tensors.emplace(user->first, extract_tensor(user->second, storage, here));
    }
  }
  return tensors;
}

void check_byte_order(const ZipArchive& archive, const std::string& folder,
                      std::string_view where) {
  const std::string member = folder + "byteorder";
  if (!archive.contains(member)) return;  // older PyTorch: little-endian
  const std::vector<std::byte> bytes = archive.read(member);
  constexpr std::string_view kLittle = "little";
  if (bytes.size() != kLittle.size() ||
      std::memcmp(bytes.data(), kLittle.data(), kLittle.size()) != 0) {
    throw InputError(where, "was saved on a big-endian machine, which is not supported");
  }
}

Checkpoint read_checkpoint(const ZipArchive& archive, std::string_view where) {
  const std::string folder = archive_folder(archive, where);
  check_byte_order(archive, folder, where);
  const std::string member = folder + "data.pkl";
  const std::string where_pickle = fmt::format("{}: {}", where, in_quotes(member));
  if (archive.sizes().at(member) > kLargestPickle) {
    throw InputError(where_pickle, fmt::format("is larger than {} bytes", kLargestPickle));
  }
  const std::vector<std::byte> bytes = archive.read(member);
  const Pickle pickle = parse_pickle(bytes, where_pickle);

  Checkpoint checkpoint;
  const auto stored = read_state_dict(find_state_dict(*pickle.top, where), where);
  for (const char* key : {"hparams", "hyper_parameters"}) {
    const PickleValue* options = find(*dictionary_items(*pickle.top), key);
    if (options != nullptr) {
      checkpoint.hparams = read_options(*options, where);
      break;
    }
  }
  checkpoint.state_dict = load_tensors(stored, archive, folder, where);
  return checkpoint;
}

}  // namespace

Checkpoint import_checkpoint(const std::filesystem::path& path) {
  return read_checkpoint(ZipArchive(path), path.string());
}

Checkpoint parse_checkpoint(std::span<const std::byte> bytes, std::string_view where) {
  return read_checkpoint(ZipArchive(bytes, where), where);
}

}  // namespace earpoint
