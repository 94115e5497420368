#include "page_options.h"

#include <earpoint/serve/clip_library.h>

void add_page_options(CLI::App& command, earpoint::PageAddress& address) {
  command
      .add_option("--host", address.host,
                  "Address to listen at; 0.0.0.0: all networks of this computer")
      ->capture_default_str();
  command.add_option("--port", address.port, "Port; 0 takes any that is free")
      ->check(CLI::Range(0, 65535))
      ->capture_default_str();
}

earpoint::PageAddress with_token(earpoint::PageAddress address) {
  if (!earpoint::is_loopback(address.host)) address.token = earpoint::unguessable_name();
  return address;
}
