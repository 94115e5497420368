#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/weights/pickle.h>
#include <earpoint/weights/tensor.h>

namespace earpoint {

/// A tensor as PyTorch stores it: a view, with offset and strides, into a storage that other
/// tensors may share. All counts are in elements.
struct StoredTensor {
  std::string storage_key;
  DType dtype = DType::f32;
  std::int64_t storage_elements = 0;
  std::int64_t offset = 0;
  std::vector<std::int64_t> shape;
  std::vector<std::int64_t> strides;

  /// Bytes when it stands alone.
  [[nodiscard]] std::uint64_t size_bytes() const;
};

/// Reads what `torch._utils._rebuild_tensor_v2` would be called with (or _rebuild_parameter, which
/// wraps it), and checks it: no negative or overflowing sizes, and every element inside of the
/// storage's claimed length.
/// @param where  file and tensor, for messages
/// @throws InputError if the value is not a tensor or the check fails
StoredTensor stored_tensor_from(const PickleValue& value, std::string_view where);

/// Copies the tensor out of its storage.
/// @param storage  bytes of the storage
/// @throws InputError if the storage has another length than claimed, or a boolean is not 0 or 1
Tensor extract_tensor(const StoredTensor& stored, std::span<const std::byte> storage,
                      std::string_view where);

}  // namespace earpoint
