#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <string_view>
#include <vector>

namespace earpoint {

/// A value as a pickle describes it. It is only a description: what Python would make by calling
/// something is kept as `object`, with the name of what would be called and its arguments.
struct PickleValue {
  enum class Kind : std::uint8_t {
    none,
    boolean,
    integer,
    real,
    string,         ///< `text`, UTF-8
    bytes,          ///< `text`
    big_integer,    ///< an integer beyond 64 bits; its value is not kept
    list,           ///< `items`
    tuple,          ///< `items`
    set,            ///< `items`
    dict,           ///< `items`: key, value, key, value, ... in the order of the file
    global,         ///< a class or function: `items` are two strings, module and name
    object,         ///< `items`: what to call, its arguments, its state, then what was added
    persistent_id,  ///< `items`: the id, a value outside of the pickle
  };

  Kind kind = Kind::none;
  union {
    bool boolean;
    std::int64_t integer = 0;
    double real;
  };
  std::string_view text;  ///< into the pickle's bytes
  std::vector<const PickleValue*> items;

  /// Whether this is the class or function of that name.
  [[nodiscard]] bool is_global(std::string_view module, std::string_view name) const;
  /// Whether this is an object made by calling that class or function.
  [[nodiscard]] bool is_made_by(std::string_view module, std::string_view name) const;

  /// Of an object: the value from BUILD; a `none` without it.
  [[nodiscard]] const PickleValue& state() const { return *items[kState]; }
  /// Of an object: its arguments.
  [[nodiscard]] const PickleValue& arguments() const { return *items[kArguments]; }
  /// Of an object: what was added to it, as in a dict or list.
  [[nodiscard]] std::span<const PickleValue* const> entries() const {
    return std::span(items).subspan(kEntries);
  }

  static constexpr std::size_t kCallable = 0;
  static constexpr std::size_t kArguments = 1;
  static constexpr std::size_t kState = 2;
  static constexpr std::size_t kEntries = 3;
};

/// The values of one pickle; they live as long as this.
struct Pickle {
  std::deque<PickleValue> values;
  const PickleValue* top = nullptr;
};

/// Reads a pickle of protocol 2 to 4 (what PyTorch writes; the textual opcodes of protocol 0 and
/// the extension registry are not known). Never calls anything. Values may be shared and may even
/// contain themselves: callers must limit how deep they go.
/// @param bytes  must outlive the result
/// @param where  file and member, for messages
/// @throws InputError for an unknown opcode, a truncated or malformed pickle, or one with more than
///         a million values
Pickle parse_pickle(std::span<const std::byte> bytes, std::string_view where);

}  // namespace earpoint
