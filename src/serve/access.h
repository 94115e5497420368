#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <httplib.h>

namespace earpoint {

/// Who may ask a server for anything.
///
/// Without a token only requests that name this computer are answered, so that no page of another
/// site reaches the server by a name of its own (DNS rebinding). With a token, which others do not
/// know, whoever brings it: first in the address, then in a cookie. Either way another site's page
/// may not send anything (Origin).
class Access {
 public:
  /// @param token  empty: none is asked for
  Access(std::string host, std::string token) : host_(std::move(host)), token_(std::move(token)) {}

  void set_port(int port) { port_ = port; }

  struct Refusal {
    int status = 0;
    std::string why;
  };
  /// @return nothing if the request may be answered
  [[nodiscard]] std::optional<Refusal> refusal(const httplib::Request& request) const;

  /// The cookie for whoever has brought the token in the address; nothing for others.
  [[nodiscard]] std::optional<std::string> cookie(const httplib::Request& request) const;

 private:
  [[nodiscard]] bool names_this_host(std::string_view host) const;
  [[nodiscard]] bool is_token(std::string_view word) const;
  [[nodiscard]] std::string cookie_name() const;

  std::string host_;
  std::string token_;
  int port_ = 0;
};

}  // namespace earpoint
