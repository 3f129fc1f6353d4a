#include <memory>

#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/options.h"
#include "cli/replay_recording.h"

namespace tandem::cli {

namespace {

struct ReplayArguments {
  std::string file;
  JsonOption json;
};

void replay(const ReplayArguments& a) {
  const ReplayResult r = replay_recording(a.file);
  nlohmann::ordered_json json{{"file", a.file},
                              {"role", r.role},
                              {"user", r.user},
                              {"scene", r.scene.name},
                              {"complete", r.complete},
                              {"records_lost", r.records_lost},
                              {"ticks", r.ticks},
                              {"packets", r.packets},
                              {"skipped_slots", r.skipped_slots},
                              {"same", !r.difference.has_value()}};
  std::string text =
      fmt::format("{}: {} {} of scene {}, slots {} to {}, {} missed, {} packets\n", a.file, r.role,
                  r.user, r.scene.name, r.first_slot, r.last_slot, r.skipped_slots, r.packets);
  if (!r.complete) text += "the recording was not closed in order: what was safe is compared\n";
  if (r.records_lost > 0)
    text += fmt::format("{} records are missing from it: a difference may come from that\n",
                        r.records_lost);
  if (r.difference) {
    const ReplayDifference& d = *r.difference;
    json["difference"] = {
        {"slot", d.slot}, {"quantity", d.quantity}, {"expected", d.expected}, {"got", d.got}};
    text += fmt::format("differs first in slot {}: {} was {}, is {}\n", d.slot, d.quantity,
                        d.expected, d.got);
  } else {
    text += fmt::format("{} ticks, bit for bit the same\n", r.ticks);
  }
  if (!a.json.to_stdout()) std::fputs(text.c_str(), stdout);
  a.json.write(json);
  if (r.difference) throw Failed("");
}

}  // namespace

void add_replay(CLI::App& app) {
  auto arguments = std::make_shared<ReplayArguments>();
  CLI::App* command = app.add_subcommand(
      "replay", "re-steps a recording through the laws and reports the first differing bit");
  command->add_option("file", arguments->file, "recording of a server, client or replica (.h5)")
      ->required();
  arguments->json.add(*command);
  command->callback([arguments] { replay(*arguments); });
}

}  // namespace tandem::cli
