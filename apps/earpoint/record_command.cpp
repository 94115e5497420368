#include "record_command.h"

namespace earpoint {

void add_record_command(CLI::App& app) {
  CLI::App* record = app.add_subcommand(
      "record", "Recorded sessions: several cameras with binaural sound, people with microphones.");
  record->require_subcommand(1);
  add_record_prepare_command(*record);
  add_record_simulate_command(*record);
  add_record_sync_command(*record);
}

}  // namespace earpoint
