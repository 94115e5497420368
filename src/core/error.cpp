#include <earpoint/error.h>

namespace earpoint {
namespace {

std::string compose(std::string_view where, std::string_view problem, std::string_view hint) {
  std::string message;
  message.append(where);
  if (!where.empty()) message.append(": ");
  message.append(problem);
  if (!hint.empty()) message.append("; ").append(hint);
  // Keeps the message on one line, whatever a file's name or contents hold.
  for (char& c : message) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  return message;
}

}  // namespace

InputError::InputError(std::string_view where, std::string_view problem, std::string_view hint)
    : std::runtime_error(compose(where, problem, hint)) {}

namespace detail {

void check_failed(const char* condition, const char* file, int line) {
  throw std::logic_error(std::string("check failed: ") + condition + " at " + file + ":" +
                         std::to_string(line));
}

}  // namespace detail
}  // namespace earpoint
