#include <earpoint/weights/pickle_writer.h>

#include <bit>
#include <limits>
#include <utility>

namespace earpoint {

PickleWriter::PickleWriter() {
  code('\x80');
  code('\x02');
}

void PickleWriter::code(char opcode) { bytes_.push_back(static_cast<std::byte>(opcode)); }

void PickleWriter::raw(std::string_view bytes) {
  for (const char c : bytes) code(c);
}

void PickleWriter::boolean(bool value) { code(value ? '\x88' : '\x89'); }

void PickleWriter::integer(std::int64_t value) {
  int bytes = 8;
  if (value >= std::numeric_limits<std::int32_t>::min() &&
      value <= std::numeric_limits<std::int32_t>::max()) {
    code('J');
    bytes = 4;
  } else {
    // LONG1: a count of bytes, then two's complement.
    code('\x8a');
    code('\x08');
  }
  const auto bits = static_cast<std::uint64_t>(value);
  for (int i = 0; i < bytes; ++i) bytes_.push_back(static_cast<std::byte>(bits >> (8 * i)));
}

void PickleWriter::real(double value) {
  code('G');
  const auto bits = std::bit_cast<std::uint64_t>(value);
  for (int i = 7; i >= 0; --i) bytes_.push_back(static_cast<std::byte>(bits >> (8 * i)));
}

void PickleWriter::text(std::string_view value) {
  code('X');
  const auto size = static_cast<std::uint32_t>(value.size());
  for (int i = 0; i < 4; ++i) bytes_.push_back(static_cast<std::byte>(size >> (8 * i)));
  raw(value);
}

void PickleWriter::global(std::string_view module, std::string_view name) {
  code('c');
  raw(module);
  code('\n');
  raw(name);
  code('\n');
}

void PickleWriter::empty_dict() { code('}'); }
void PickleWriter::empty_tuple() { code(')'); }
void PickleWriter::open() { code('('); }
void PickleWriter::set_items() { code('u'); }
void PickleWriter::tuple() { code('t'); }
void PickleWriter::persistent_id() { code('Q'); }
void PickleWriter::call() { code('R'); }
void PickleWriter::new_object() { code('\x81'); }
void PickleWriter::build() { code('b'); }

std::vector<std::byte> PickleWriter::finish() {
  code('.');
  return std::move(bytes_);
}

}  // namespace earpoint
