#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace earpoint {

/// Writes a pickle of protocol 2, operation by operation: as much of it as PyTorch's checkpoints
/// need. Values are written in order; a container's entries stand between open() and the operation
/// that closes it.
/// Source: Python's `pickletools`.
class PickleWriter {
 public:
  PickleWriter();

  void boolean(bool value);
  void integer(std::int64_t value);
  void real(double value);
  void text(std::string_view value);  ///< UTF-8
  /// A class or function.
  void global(std::string_view module, std::string_view name);

  void empty_dict();
  void empty_tuple();
  void open();           ///< marks where entries begin
  void set_items();      ///< key, value, key, value, ... since the mark go into the dict before it
  void tuple();          ///< the values since the mark become one
  void persistent_id();  ///< the value on top is the id of something outside of the pickle
  void call();           ///< the function and the tuple of its arguments on top become its result
  void new_object();     ///< likewise a class, without its initialiser
  void build();          ///< the value on top becomes the state of the object below it

  /// @return the pickle, whose one value is what was written
  [[nodiscard]] std::vector<std::byte> finish();

 private:
  void code(char opcode);
  void raw(std::string_view bytes);

  std::vector<std::byte> bytes_;
};

}  // namespace earpoint
