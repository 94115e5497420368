#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include <earpoint/weights/tensor.h>

namespace earpoint {

/// One named option of a training run.
using HyperParameter = std::variant<bool, std::int64_t, double, std::string>;

/// The contents of a PyTorch checkpoint of a network.
struct Checkpoint {
  std::map<std::string, Tensor> state_dict;
  std::map<std::string, HyperParameter> hparams;  ///< empty if the file has none
};

/// Reads a checkpoint that PyTorch saved: a zip archive (its members stored, not compressed) with
/// a pickle inside. The top value is a dictionary; the weights are its "state_dict", or its
/// "predictor", or the dictionary itself if all its values are tensors. "hparams" or
/// "hyper_parameters" become `hparams`; options that are not a flag, a number or a string are left
/// out. Everything else (optimizer states, epochs, ...) is skipped.
///
/// Nothing in the file is ever executed: the pickle is read by a small interpreter of our own that
/// knows data only. Classes that it does not know are kept as opaque values, which are an error
/// only where a tensor or an option is needed. Memory stays within a small multiple of the file's
/// size whatever the file claims.
///
/// @throws InputError, one line, naming the file and the member or tensor
/// Source: the released ViGAS code's checkpoints; the pickle protocol, Python's `pickletools`.
[[nodiscard]] Checkpoint import_checkpoint(const std::filesystem::path& path);

/// The same for bytes in memory.
/// @param where  stands for the file in messages
[[nodiscard]] Checkpoint parse_checkpoint(std::span<const std::byte> bytes, std::string_view where);

}  // namespace earpoint
