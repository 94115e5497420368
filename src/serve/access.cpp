#include "access.h"

#include <algorithm>
#include <cstddef>

#include <fmt/format.h>

#include <earpoint/serve/page_server.h>

namespace earpoint {

bool is_loopback(std::string_view host) {
  return host == "localhost" || host == "::1" || host.starts_with("127.");
}

std::string Access::cookie_name() const { return fmt::format("earpoint-{}", port_); }

bool Access::names_this_host(std::string_view host) const {
  for (const std::string_view name : {std::string_view("localhost"), std::string_view("127.0.0.1"),
                                      std::string_view("[::1]"), std::string_view(host_)}) {
    if (host == name || host == fmt::format("{}:{}", name, port_)) return true;
  }
  return false;
}

// Takes the same time wherever the words differ.
bool Access::is_token(std::string_view word) const {
  if (word.size() != token_.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < word.size(); ++i) {
    difference |= static_cast<unsigned char>(word[i]) ^ static_cast<unsigned char>(token_[i]);
  }
  return difference == 0;
}

std::optional<Access::Refusal> Access::refusal(const httplib::Request& request) const {
  const std::string host = request.get_header_value("Host");
  if (token_.empty() && !names_this_host(host)) {
    return Refusal{403, "this server answers to its own address only"};
  }
  const std::string origin = request.get_header_value("Origin");
  if (!origin.empty() && origin != "http://" + host) {
    return Refusal{403, "pages of another site may not ask this server"};
  }
  if (token_.empty() || is_token(request.get_param_value("token"))) return std::nullopt;
  const std::string cookies = request.get_header_value("Cookie");
  const std::string start = cookie_name() + "=";
  for (std::size_t at = 0; at < cookies.size();) {
    const std::size_t end = std::min(cookies.find(';', at), cookies.size());
    const std::string_view pair = std::string_view(cookies).substr(at, end - at);
    if (pair.starts_with(start) && is_token(pair.substr(start.size()))) return std::nullopt;
    at = end + 1;
    while (at < cookies.size() && cookies[at] == ' ') ++at;
  }
  return Refusal{401,
                 "open the whole address that was printed when the server started, with its token"};
}

std::optional<std::string> Access::cookie(const httplib::Request& request) const {
  if (token_.empty() || !is_token(request.get_param_value("token"))) return std::nullopt;
  return fmt::format("{}={}; Path=/; HttpOnly; SameSite=Strict", cookie_name(), token_);
}

}  // namespace earpoint
