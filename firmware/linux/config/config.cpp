// SPDX-License-Identifier: MIT
#include "linux/config/config.hpp"

#include <CLI/CLI.hpp>
#include <sstream>

#include "app/version.hpp"
#include "linux/config/config_values.hpp"

namespace flotilla::target {
namespace {

constexpr int kMistake = 2;

constexpr const char* kDescription =
    R"(Autopilot of a twin-propeller boat: MAVLink in, DroneCAN out.

Every option is also a key of the configuration file (TOML, without the dashes); the command line
wins. A list of links on the command line replaces the file's, a parameter replaces its namesake.)";

// A flaw in a decoder of messages or frames must not give an attacker the whole machine.
constexpr const char* kNotAsRoot =
    "does not run as root: use its systemd unit, firmware/linux/flotillad.service, or start "
    "it as another user (setpriv --reuid=USER --regid=GROUP --init-groups flotillad ...)";

constexpr const char* kFooter = R"(
CAN buses:
  socketcan:IF           a CAN interface of Linux, such as can0 or vcan0
  mcast:N[:ADDRESS]      DroneCAN over UDP multicast, bus N; stays on this machine without ADDRESS

MAVLink links, each followed by its options:
  ,rate=BYTES            limits telemetry to so many bytes per second; 0: no limit. Default: four
                         fifths of a serial port's baud rate; elsewhere no limit
  ,signing=POLICY        off: no signatures; accept: signs, accepts unsigned messages too; required:
                         accepts signed ones only. Default: required with a signing-key, else off
and these addresses:
  udpin:[HOST:]PORT      listens on that address of this machine, 127.0.0.1 without HOST; answers
                         every sender
  udpout:HOST:PORT       sends to that address and receives only from it
  udpbcast:HOST:PORT     sends to a broadcast address
  serial:DEVICE:BAUD     a serial port, such as serial:/dev/ttyUSB0:57600,rate=3000

A parameter given here overrides the saved one at every start; --param overrides --param-file, both
override the configuration file.)";

struct Options {
  std::string config, can, state_dir, signing_key, log, stats, stop, priority;
  std::vector<std::string> mavlink, param, param_file;
  bool lock_memory = false, check = false;
};

/// Runs `read`; an error names the option.
template <class Read>
void option(const char* name, Read read) {
  try {
    read();
  } catch (const ValueError& error) {
    throw ConfigError(std::string(name) + ": " + error.what());
  }
}

void override_parameter(const std::string& text, Config& config) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) throw ValueError("\"" + text + "\" is not NAME=VALUE");
  const std::string name = text.substr(0, equals), value = text.substr(equals + 1);
  config.param[name] = parameter_value(name, number<double>(value), value);
}

void define(CLI::App& app, Options& options) {
  const Config defaults;
  app.add_option("--config", options.config, "Configuration file")->type_name("FILE");
  app.add_option("--can", options.can, "CAN bus, default " + defaults.can)->type_name("BUS");
  app.add_option("--mavlink", options.mavlink, "MAVLink link, repeatable, at least one")
      ->type_name("LINK[,OPTION…]")
      ->allow_extra_args(false);
  app.add_option("--param", options.param, "Parameter, repeatable")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
  app.add_option("--param-file", options.param_file,
                 "Parameter file of a ground station, such as sil/hulls/otter.param, repeatable")
      ->type_name("FILE")
      ->allow_extra_args(false);
  app.add_option("--state-dir", options.state_dir,
                 "Where parameters and node ids are kept, default " + defaults.state_dir.string())
      ->type_name("DIR");
  app.add_option("--signing-key", options.signing_key,
                 "Key of MAVLink signing: 32 bytes or 64 hexadecimal digits, mode 0600; \"\": none")
      ->type_name("FILE");
  app.add_option("--log", options.log, "Where logs are written; \"\": none, the default")
      ->type_name("DIR");
  app.add_option("--stats", options.stats,
                 "Where the loop's latencies and counters are written at exit; \"\": nowhere")
      ->type_name("FILE");
  app.add_option("--stop-gpio", options.stop,
                 "GPIO line of a normally closed stop switch to ground; \"\": none, the default")
      ->type_name("CHIP:LINE");
  app.add_option("--priority", options.priority,
                 "SCHED_FIFO priority of the control loop, 1 to 99; 0: off, the default")
      ->type_name("N");
  app.add_flag("--lock-memory", options.lock_memory,
               "Lock all memory in RAM; --lock-memory=false overrides the file");
  app.add_flag("--check", options.check, "Only check the configuration");
  app.set_version_flag("--version", "flotillad " + std::to_string(app::kVersionMajor) + "." +
                                        std::to_string(app::kVersionMinor) + " (" +
                                        std::string(app::source_revision()) + ")");
  app.footer(kFooter);
}

void require_consistency(const Config& config) {
  if (config.state_dir.empty()) throw ConfigError("state-dir: must be the name of a directory");
  if (config.mavlink.empty()) {
    throw ConfigError("no MAVLink link: give --mavlink, or --config FILE with the key mavlink");
  }
  for (const MavlinkLinkConfig& link : config.mavlink) {
    if (config.signing_key.empty() && config.policy(link) != app::SigningPolicy::kOff) {
      throw ConfigError("mavlink: signing on " + link.address + " needs a signing-key");
    }
  }
}

Config combined(const CLI::App& app, const Options& options) {
  const auto given = [&](const char* name) { return app.count(name) > 0; };
  Config config = given("--config") ? read_config_file(options.config) : Config();
  if (given("--can")) option("--can", [&] { config.can = can_address(options.can); });
  if (given("--mavlink")) {
    option("--mavlink", [&] {
      require_link_count(options.mavlink.size());
      config.mavlink.clear();
      for (const auto& text : options.mavlink) config.mavlink.push_back(mavlink_link(text));
    });
  }
  for (const auto& file : options.param_file) read_parameter_list(file, config.param);
  option("--param", [&] {
    for (const auto& text : options.param) override_parameter(text, config);
  });
  if (given("--state-dir")) config.state_dir = options.state_dir;
  if (given("--signing-key")) config.signing_key = options.signing_key;
  if (given("--log")) config.log = options.log;
  if (given("--stats")) config.stats = options.stats;
  if (given("--stop-gpio")) option("--stop-gpio", [&] { config.stop = stop_line(options.stop); });
  if (given("--priority")) {
    option("--priority",
           [&] { config.priority = priority_value(number<std::int64_t>(options.priority)); });
  }
  if (given("--lock-memory")) config.lock_memory = options.lock_memory;
  require_consistency(config);
  return config;
}

}  // namespace

std::variant<Config, Ending> read_config(std::span<const char* const> arguments, bool by_root) {
  CLI::App app(kDescription, "flotillad");
  Options options;
  define(app, options);
  try {
    // "--log=" gives an empty value; CLI11 would instead read the next option as the value.
    std::vector<const char*> words;
    std::vector<std::string> names;
    names.reserve(arguments.size());
    for (const std::string_view word : arguments) {
      const bool empty_value = word.starts_with("--") && word.ends_with('=');
      if (empty_value) names.emplace_back(word.substr(0, word.size() - 1));
      words.push_back(empty_value ? names.back().c_str() : word.data());
      if (empty_value) words.push_back("");
    }
    app.parse(static_cast<int>(words.size()), words.data());
    if (by_root) throw ConfigError(kNotAsRoot);
    Config config = combined(app, options);
    if (options.check) return Ending{0, "the configuration is valid\n"};
    return config;
  } catch (const CLI::ParseError& error) {
    std::ostringstream out, complaint;
    app.exit(error, out, complaint);
    if (error.get_exit_code() == 0) return Ending{0, out.str()};
    return Ending{kMistake, "flotillad: " + std::string(error.what()) + " (see --help)\n"};
  } catch (const ConfigError& error) {
    return Ending{kMistake, "flotillad: " + std::string(error.what()) + "\n"};
  }
}

void apply(const ParameterOverrides& overrides, app::Parameters& parameters) {
  for (const auto& [name, value] : overrides) {
    if (const app::ParameterInfo* info = app::find_parameter(name))
      parameters.*info->member = value;
  }
}

}  // namespace flotilla::target
