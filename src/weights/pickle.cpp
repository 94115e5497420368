#include <earpoint/weights/pickle.h>

#include "utf8.h"

#include <array>
#include <bit>
#include <cstring>
#include <string>
#include <unordered_map>

#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

using Kind = PickleValue::Kind;

// A checkpoint with 613 weights and their optimizer has some 40,000 values. A value costs about
// 60 bytes and may take one byte in the file, so the number is bounded, not only the file.
constexpr std::size_t kMostValues = 1'000'000;

/// The interpreter of one pickle: a stack of values, marks in it, and a memo.
class Unpickler {
 public:
  Unpickler(std::span<const std::byte> bytes, std::string_view where)
      : bytes_(bytes), where_(where) {
    none_ = make(Kind::none);
    false_ = make(Kind::boolean);
    true_ = make(Kind::boolean);
    true_->boolean = true;
    empty_tuple_ = make(Kind::tuple);
  }

  Pickle run() {
    while (true) {
      at_ = next_;
      const auto opcode = static_cast<unsigned char>(take(1).front());
      if (opcode == '.') break;
      step(opcode);
      if (stack_.size() > kMostValues || marks_.size() > kMostValues ||
          memo_.size() > kMostValues || pickle_.values.size() > kMostValues) {
        fail(fmt::format("has more than {} values", kMostValues));
      }
    }
    pickle_.top = pop();
    return std::move(pickle_);
  }

 private:
  [[noreturn]] void fail(std::string_view problem) const {
    throw InputError(fmt::format("{}: byte {}", where_, at_), problem);
  }

  // ---- bytes

  std::string_view take(std::uint64_t size) {
    if (size > bytes_.size() - next_) fail("the pickle is truncated");
    const std::string_view text(reinterpret_cast<const char*>(bytes_.data()) + next_, size);
    next_ += size;
    return text;
  }

  template <typename T>
  T take_number() {
    T value;
    std::memcpy(&value, take(sizeof(T)).data(), sizeof(T));
    return value;
  }

  std::string_view take_line() {
    const std::string_view rest(reinterpret_cast<const char*>(bytes_.data()) + next_,
                                bytes_.size() - next_);
    const std::size_t end = rest.find('\n');
    if (end == std::string_view::npos) fail("the pickle is truncated");
    next_ += end + 1;
    return rest.substr(0, end);
  }

  // ---- values and stack

  PickleValue* make(Kind kind) {
    PickleValue& value = pickle_.values.emplace_back();
    value.kind = kind;
    return &value;
  }

  void push(PickleValue* value) { stack_.push_back(value); }

  /// How deep the stack may be popped: to the last mark.
  [[nodiscard]] std::size_t floor() const { return marks_.empty() ? 0 : marks_.back(); }

  PickleValue* pop() {
    if (stack_.size() <= floor()) fail("takes a value from an empty stack");
    PickleValue* value = stack_.back();
    stack_.pop_back();
    return value;
  }

  PickleValue* top() {
    PickleValue* value = pop();
    push(value);
    return value;
  }

  /// The values above the last mark, which goes too.
  std::vector<const PickleValue*> pop_to_mark() {
    if (marks_.empty()) fail("refers to a mark that was not set");
    const auto from = stack_.begin() + static_cast<std::ptrdiff_t>(marks_.back());
    std::vector<const PickleValue*> values(from, stack_.end());
    stack_.erase(from, stack_.end());
    marks_.pop_back();
    return values;
  }

  void push_integer(std::int64_t integer) {
    PickleValue* value = make(Kind::integer);
    value->integer = integer;
    push(value);
  }

  /// Two's complement, little-endian, of any length.
  void push_long(std::string_view digits) {
    if (digits.size() > sizeof(std::int64_t)) return push(make(Kind::big_integer));
    const bool negative = !digits.empty() && (static_cast<unsigned char>(digits.back()) & 0x80U);
    std::uint64_t integer = negative ? ~std::uint64_t{0} : 0;
    std::memcpy(&integer, digits.data(), digits.size());
    push_integer(std::bit_cast<std::int64_t>(integer));
  }

  void push_real() {
    std::array<char, sizeof(double)> bytes{};
    const std::string_view big_endian = take(bytes.size());
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = big_endian[bytes.size() - 1 - i];
    PickleValue* value = make(Kind::real);
    value->real = std::bit_cast<double>(bytes);
    push(value);
  }

  void push_text(Kind kind, std::string_view text) {
    if (kind == Kind::string && !is_utf8(text)) fail("a string is not UTF-8");
    PickleValue* value = make(kind);
    value->text = text;
    push(value);
  }

  void push_sequence(Kind kind, std::vector<const PickleValue*> items) {
    PickleValue* value = make(kind);
    value->items = std::move(items);
    push(value);
  }

  void push_tuple(std::size_t size) {
    std::vector<const PickleValue*> items(size);
    for (std::size_t i = size; i-- > 0;) items[i] = pop();
    push_sequence(Kind::tuple, std::move(items));
  }

  void push_global(const PickleValue* module, const PickleValue* name) {
    if (module->kind != Kind::string || name->kind != Kind::string) {
      fail("names a class by something other than strings");
    }
    push_sequence(Kind::global, {module, name});
  }

  void push_global_lines() {
    push_text(Kind::string, take_line());
    push_text(Kind::string, take_line());
    const PickleValue* name = pop();
    push_global(pop(), name);
  }

  /// Notes what Python would call; calls nothing.
  void push_object() {
    const PickleValue* arguments = pop();
    const PickleValue* callable = pop();
    if (arguments->kind != Kind::tuple) fail("calls something with arguments that are not a tuple");
    push_sequence(Kind::object, {callable, arguments, none_});
  }

  void build() {
    const PickleValue* state = pop();
    PickleValue* target = top();
    if (target->kind == Kind::object) {
      target->items[PickleValue::kState] = state;
    } else if (target->kind != Kind::dict) {
      fail("sets the state of a value that has none");
    }
  }

  void append(const std::vector<const PickleValue*>& items) {
    PickleValue* target = top();
    if (target->kind != Kind::list && target->kind != Kind::set && target->kind != Kind::object) {
      fail("appends to a value that is not a list");
    }
    target->items.insert(target->items.end(), items.begin(), items.end());
  }

  void set_items(const std::vector<const PickleValue*>& items) {
    PickleValue* target = top();
    if (target->kind != Kind::dict && target->kind != Kind::object) {
      fail("sets an item of a value that is not a dictionary");
    }
    if (items.size() % 2 != 0) fail("sets an item without a value");
    target->items.insert(target->items.end(), items.begin(), items.end());
  }

  void set_item() {
    const PickleValue* value = pop();
    const PickleValue* key = pop();
    set_items({key, value});
  }

  void push_remembered(std::uint32_t place) {
    const auto found = memo_.find(place);
    if (found == memo_.end()) fail(fmt::format("recalls value {}, which was never kept", place));
    push(found->second);
  }

  // ---- opcodes, by the names in Python's pickletools

  void step(unsigned char opcode) {
    if (step_scalar(opcode) || step_text(opcode) || step_container(opcode) || step_stack(opcode) ||
        step_object(opcode)) {
      return;
    }
    fail(fmt::format("unknown pickle opcode 0x{:02x}", opcode));
  }

  bool step_scalar(unsigned char opcode) {
    switch (opcode) {
      case 'N':
        push(none_);
        return true;
      case 0x88:
        push(true_);
        return true;  // NEWTRUE
      case 0x89:
        push(false_);
        return true;  // NEWFALSE
      case 'J':
        push_integer(take_number<std::int32_t>());
        return true;  // BININT
      case 'K':
        push_integer(take_number<std::uint8_t>());
        return true;  // BININT1
      case 'M':
        push_integer(take_number<std::uint16_t>());
        return true;  // BININT2
      case 0x8a:
        push_long(take(take_number<std::uint8_t>()));
        return true;  // LONG1
      case 0x8b:
        push_long(take(take_number<std::uint32_t>()));
        return true;  // LONG4
      case 'G':
        push_real();
        return true;  // BINFLOAT
      default:
        return false;
    }
  }

  bool step_text(unsigned char opcode) {
    switch (opcode) {
      case 0x8c:
        push_text(Kind::string, take(take_number<std::uint8_t>()));
        return true;
      case 'X':
        push_text(Kind::string, take(take_number<std::uint32_t>()));
        return true;
      case 0x8d:
        push_text(Kind::string, take(take_number<std::uint64_t>()));
        return true;
      case 'U':  // strings of Python 2 may be bytes
      case 'C':
        push_text(Kind::bytes, take(take_number<std::uint8_t>()));
        return true;
      case 'T':
      case 'B':
        push_text(Kind::bytes, take(take_number<std::uint32_t>()));
        return true;
      case 0x8e:
      case 0x96:
        push_text(Kind::bytes, take(take_number<std::uint64_t>()));
        return true;
      default:
        return false;
    }
  }

  bool step_container(unsigned char opcode) {
    switch (opcode) {
      case ']':
        push(make(Kind::list));
        return true;
      case 'l':
        push_sequence(Kind::list, pop_to_mark());
        return true;
      case 'a':
        append({pop()});
        return true;
      case 'e':
        append(pop_to_mark());
        return true;
      case ')':
        push(empty_tuple_);
        return true;
      case 't':
        push_sequence(Kind::tuple, pop_to_mark());
        return true;
      case 0x85:
        push_tuple(1);
        return true;
      case 0x86:
        push_tuple(2);
        return true;
      case 0x87:
        push_tuple(3);
        return true;
      case '}':
        push(make(Kind::dict));
        return true;
      case 's':
        set_item();
        return true;
      case 'u':
        set_items(pop_to_mark());
        return true;
      case 0x8f:
        push(make(Kind::set));
        return true;  // EMPTY_SET
      case 0x90:
        append(pop_to_mark());
        return true;  // ADDITEMS
      case 0x91:
        push_sequence(Kind::set, pop_to_mark());
        return true;  // FROZENSET
      default:
        return false;
    }
  }

  bool step_stack(unsigned char opcode) {
    switch (opcode) {
      case 0x80:
        return take_protocol();
      case 0x95:
        take(sizeof(std::uint64_t));
        return true;  // FRAME: only advice to a reader
      case '(':
        marks_.push_back(stack_.size());
        return true;
      case '0':
        pop();
        return true;
      case '1':
        pop_to_mark();
        return true;
      case '2':
        push(top());
        return true;
      case 'h':
        push_remembered(take_number<std::uint8_t>());
        return true;
      case 'j':
        push_remembered(take_number<std::uint32_t>());
        return true;
      case 'q':
        memo_[take_number<std::uint8_t>()] = top();
        return true;
      case 'r':
        memo_[take_number<std::uint32_t>()] = top();
        return true;
      case 0x94:
        memo_[static_cast<std::uint32_t>(memo_.size())] = top();
        return true;  // MEMOIZE
      default:
        return false;
    }
  }

  bool step_object(unsigned char opcode) {
    switch (opcode) {
      case 'c':
        push_global_lines();
        return true;
      case 0x93: {  // STACK_GLOBAL
        const PickleValue* name = pop();
        push_global(pop(), name);
        return true;
      }
      case 'R':
      case 0x81:
        push_object();
        return true;  // REDUCE, NEWOBJ
      case 0x92: {    // NEWOBJ_EX: the named arguments are not kept
        pop();
        push_object();
        return true;
      }
      case 'b':
        build();
        return true;
      case 'Q':
        push_sequence(Kind::persistent_id, {pop()});
        return true;
      default:
        return false;
    }
  }

  bool take_protocol() {
    const auto protocol = take_number<std::uint8_t>();
    if (protocol < 2 || protocol > 5) fail(fmt::format("unknown pickle protocol {}", protocol));
    return true;
  }

  std::span<const std::byte> bytes_;
  std::string where_;
  std::size_t at_ = 0;    ///< of the opcode in hand
  std::size_t next_ = 0;  ///< byte to be read
  Pickle pickle_;
  std::vector<PickleValue*> stack_;
  std::vector<std::size_t> marks_;
  std::unordered_map<std::uint32_t, PickleValue*> memo_;
  PickleValue* none_;
  PickleValue* false_;
  PickleValue* true_;
  PickleValue* empty_tuple_;
};

}  // namespace

bool PickleValue::is_global(std::string_view module, std::string_view name) const {
  return kind == Kind::global && items[0]->text == module && items[1]->text == name;
}

bool PickleValue::is_made_by(std::string_view module, std::string_view name) const {
  return kind == Kind::object && items[kCallable]->is_global(module, name);
}

Pickle parse_pickle(std::span<const std::byte> bytes, std::string_view where) {
  return Unpickler(bytes, where).run();
}

}  // namespace earpoint
