#include "page_options.h"

#include <earpoint/serve/clip_library.h>

namespace earpoint {

void add_page_options(CLI::App& command, PageAddress& address) {
  command
      .add_option("--host", address.host,
                  "Address to listen at; 0.0.0.0: all networks of this computer")
      ->capture_default_str();
  command.add_option("--port", address.port, "Port; 0 takes any that is free")
      ->check(CLI::Range(0, 65535))
      ->capture_default_str();
}

PageAddress with_token(PageAddress address) {
  if (!is_loopback(address.host)) address.token = unguessable_name();
  return address;
}

}  // namespace earpoint
