#include "harness/real_network.h"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <poll.h>

#include <fmt/format.h>

#include "core/clock.h"
#include "harness/caretaker.h"
#include "harness/child.h"
#include "harness/guest.h"
#include "harness/harness_error.h"
#include "harness/node_plan.h"
#include "harness/qdisc_player.h"
#include "scene/scene_text.h"

namespace tandem::harness {
namespace {

using nlohmann::ordered_json;

constexpr int kNodePort = 7000, kProbePort = 7001;
constexpr std::int64_t kProbeStart_ns =
    50'000'000;  // of a probe, from its fork to its first packet

/// A handshake of a few round trips [s].
[[nodiscard]] double time_to_join(const SessionRequest& request) {
  const auto worst = [](const Condition& c) { return c.delay + 3.0 * c.jitter; };
  return 4.0 * (worst(request.network.there) + worst(request.network.back));
}

[[nodiscard]] std::vector<std::string> real_time_words() {
  // A clock read costs 14 us in the guest: sleep, never spin; no page of it is ever swapped.
  if (inside_guest()) return {"--spin-us", "0", "--no-memory-lock", "--no-dma-latency", "--quiet"};
  return {"--quiet"};
}

[[nodiscard]] ordered_json read_json(const std::string& file) {
  std::ifstream in(file);
  return in ? ordered_json::parse(in, nullptr, false) : ordered_json();
}

void write_scene(const std::string& file, const core::Scene& scene) {
  std::ofstream out(file);
  out << scene::to_text(scene);
  if (!out.flush()) throw HarnessError("cannot write " + file + ": disk full or no such folder");
}

void stop_if_interrupted() {
  if (Caretaker::interrupted()) throw Interrupted();
}

}  // namespace

const Condition& way_out(const LinkConditions& network, int site) {
  return site == 0 ? network.there : network.back;
}

RealNetwork::RealNetwork(const std::string& name, int sites, NodeProgram program)
    : spaces_(name, std::max(sites, 2)), program_(std::move(program)) {}

/// A session from its start to its end.
class RunningSession {
 public:
  RunningSession(RealNetwork& network, const SessionRequest& request, std::int64_t start_ns)
      : network_(network),
        request_(request),
        sites_(node_count(request.scene)),
        end_ns_(start_ns + std::llround(1e9 * request.seconds)) {
    session_.start_ns = start_ns;
    write_scene(request.base + ".scene", request.scene);
    shape_all();
    start_all();
  }

  [[nodiscard]] bool running() const {
    return std::any_of(nodes_.begin(), nodes_.end(),
                       [](const Started& node) { return node.child.running(); });
  }
  void append_outputs(std::vector<pollfd>& ends) const {
    for (const Started& node : nodes_)
      ends.push_back({.fd = node.child.output(), .events = POLLIN, .revents = 0});
  }

  /// Takes what was said and looks after those who ended or should have.
  void look() {
    for (Started& node : nodes_) {
      const bool ran = node.child.running();
      node.child.listen(0);
      if (node.joined_ns == 0 && node.child.said().find(" joined ") != std::string::npos)
        node.joined_ns = core::MonotonicClock().now_ns();
      if (ran && !node.child.running() && node.child.status() != 0)
        fail(fmt::format("{} ended with {}:\n{}", node.plan.name, *node.child.status(),
                         node.child.said()));
    }
    constexpr std::int64_t kPatience_ns = 8'000'000'000;  // closing recordings, a stalled host
    const std::int64_t late_ns = core::MonotonicClock().now_ns() - end_ns_;
    if (running() && late_ns > kPatience_ns) fail("did not end within 8 s after its time");
    if (late_ns > 2 * kPatience_ns)
      for (Started& node : nodes_) node.child.signal(SIGKILL);
  }

  [[nodiscard]] RealSession result() {
    for (const auto& player : players_)
      if (const std::string said = player->failure(); !said.empty())
        fail("tc could not change the condition: " + said);
    session_.ready_ns = nodes_.empty() ? 0 : nodes_.front().joined_ns;
    for (const Started& node : nodes_)
      session_.ready_ns = session_.ready_ns == 0 || node.joined_ns == 0
                              ? 0
                              : std::max(session_.ready_ns, node.joined_ns);
    for (Started& node : nodes_) {
      RealNode& done = session_.nodes.emplace_back();
      done.name = node.plan.name;
      done.user = node.plan.user;
      done.recording = node.plan.recording;
      done.said = node.child.said();
      done.exit_status = node.child.status().value_or(-1);
      done.report = read_json(node.plan.report_file);
      if (!done.report.is_object())
        fail(done.name + " left no report; it said:\n" + done.said);
      else if (done.report.contains("recording"))  // disk full: the session went on without it
        if (const std::string why = done.report["recording"].value("failure", ""); !why.empty())
          fail(done.name + ": " + why);
    }
    return std::move(session_);
  }

 private:
  struct Started {
    PlannedNode plan;
    Child child;
    std::int64_t joined_ns = 0;
  };

  void fail(const std::string& why) {
    if (!session_.failure.empty()) return;
    session_.failure = why;
    for (Started& node : nodes_) node.child.signal(SIGTERM);
  }

  void shape_all() {
    for (int site = 0; site < network_.spaces_.count(); ++site) {
      const Condition condition = site < sites_ ? way_out(request_.network, site) : Condition{};
      auto changes = changes_of(condition, request_.seconds);
      std::vector<std::string> arguments = netem_arguments(at_time(condition, 0.0));
      if (arguments.empty() && !changes.empty()) arguments = {"delay", "0ms"};  // to be changed
      network_.spaces_.shape(site, arguments);
      if (!changes.empty()) network_.spaces_.forget_shape(site);
      if (!changes.empty())
        players_.push_back(std::make_unique<QdiscPlayer>(network_.spaces_.name_of(site),
                                                         std::move(changes), session_.start_ns));
    }
  }

  void start_all() {
    NodePlan plan;
    plan.scene_file = request_.base + ".scene";
    plan.base = request_.base;
    plan.seconds = request_.seconds;
    plan.address_of = [&](int site) {
      return fmt::format("{}:{}", network_.spaces_.address_of(site), kNodePort);
    };
    plan.more = real_time_words();
    // Sweeps look beyond the boundary on purpose, and have their own prediction.
    plan.more.insert(plan.more.end(), {"--on-unstable", "ignore", "--without-silence", "--start-ns",
                                       std::to_string(session_.start_ns)});
    for (PlannedNode& node : plan_nodes(request_.scene, plan)) {
      std::error_code ignored;
      for (const std::string& old : {node.recording, node.report_file})
        std::filesystem::remove(old, ignored);  // or an old one would be taken for this run's
      std::vector<std::string> words = node.words;
      words.insert(words.begin(), network_.program_.file);
      Child child(words, {.network = network_.spaces_.name_of(static_cast<int>(nodes_.size())),
                          .environment = {},
                          .takes_input = false,
                          .main = network_.program_.main});
      nodes_.push_back({std::move(node), std::move(child)});
    }
  }

  RealNetwork& network_;
  SessionRequest request_;
  int sites_;
  std::int64_t end_ns_;
  RealSession session_;
  std::vector<std::unique_ptr<QdiscPlayer>> players_;
  std::vector<Started> nodes_;
};

std::vector<RealSession> run_sessions(const std::vector<Assignment>& assignments, double lead) {
  stop_if_interrupted();
  double handshake = 0.0;
  for (const Assignment& a : assignments) handshake = std::max(handshake, time_to_join(a.request));
  const std::int64_t start_ns =
      core::MonotonicClock().now_ns() + std::llround(1e9 * (lead + handshake));
  std::vector<std::unique_ptr<RunningSession>> sessions;
  for (const Assignment& a : assignments) {
    // Ticks of different sessions are spread over the period, so that they wait less for each
    // other.
    const double share = static_cast<double>(sessions.size()) /
                         static_cast<double>(assignments.size()) * a.request.scene.tick();
    sessions.push_back(std::make_unique<RunningSession>(*a.network, a.request,
                                                        start_ns + std::llround(1e9 * share)));
  }
  const auto any_runs = [&] {
    return std::any_of(sessions.begin(), sessions.end(),
                       [](const auto& session) { return session->running(); });
  };
  while (any_runs()) {
    stop_if_interrupted();
    std::vector<pollfd> ends;
    for (const auto& session : sessions) session->append_outputs(ends);
    poll(ends.data(), ends.size(), 100);
    for (const auto& session : sessions) session->look();
  }
  std::vector<RealSession> done;
  for (const auto& session : sessions) done.push_back(session->result());
  return done;
}

nlohmann::json RealNetwork::probe_once(const ProbePlan& plan, int bytes, const Condition* played) {
  stop_if_interrupted();
  const std::string address = fmt::format("{}:{}", spaces_.address_of(1), kProbePort);
  Child server({program_.file, "probe", "--serve", "--bind", address, "--priority",
                inside_guest() ? "50" : "0"},
               {.network = spaces_.name_of(1),
                .environment = {},
                .takes_input = false,
                .main = program_.main});
  for (int i = 0; i < 100 && server.said().find("answering") == std::string::npos; ++i)
    if (!server.listen(50)) throw HarnessError("tandem probe --serve ended: " + server.said());
  std::unique_ptr<QdiscPlayer> player;
  if (played != nullptr)
    player = std::make_unique<QdiscPlayer>(spaces_.name_of(0), changes_of(*played, plan.seconds),
                                           core::MonotonicClock().now_ns() + kProbeStart_ns);
  Child client({program_.file, "probe", address, "--rate", fmt::format("{}", plan.rate_hz),
                "--seconds", fmt::format("{}", plan.seconds), "--bytes", std::to_string(bytes),
                "--priority", inside_guest() ? "50" : "0", "--json", "-"},
               {.network = spaces_.name_of(0),
                .environment = {},
                .takes_input = false,
                .main = program_.main});
  constexpr double kPatience = 10.0;
  (void)client.wait(plan.seconds + kPatience);
  stop_if_interrupted();
  if (player != nullptr)
    if (const std::string said = player->failure(); !said.empty())
      throw HarnessError("tc could not change the condition: " + said);
  // Its table goes to standard error, which is in the same text before the object.
  const std::string& said = client.said();
  const std::size_t begin = said.find("{\n");
  const auto json = begin == std::string::npos
                        ? nlohmann::json()
                        : nlohmann::json::parse(said.substr(begin), nullptr, false);
  if (!json.is_object()) throw HarnessError("tandem probe gave no result: " + said);
  return json;
}

SeenLink RealNetwork::probe(const Condition& condition, const ProbePlan& plan) {
  constexpr int kBytes = 64;
  const auto p50 = [](const nlohmann::json& j) { return j["round_trip_s"]["p50"].get<double>(); };
  if (clear_p50_ < 0.0) {
    spaces_.shape(0, {});
    spaces_.shape(1, {});
    clear_p50_ = p50(probe_once({.rate_hz = 500.0, .seconds = 0.6}, kBytes));
  }
  const bool changes = !changes_of(condition, plan.seconds).empty();
  std::vector<std::string> arguments = netem_arguments(at_time(condition, 0.0));
  if (arguments.empty() && changes) arguments = {"delay", "0ms"};  // to be changed
  spaces_.shape(1, {});
  spaces_.shape(0, arguments);
  if (changes) spaces_.forget_shape(0);
  const auto seen = probe_once(plan, kBytes, changes ? &condition : nullptr);
  SeenLink link;
  link.sent = seen["sent"];
  link.lost = seen["lost"];
  link.loss = link.sent > 0 ? static_cast<double>(link.lost) / static_cast<double>(link.sent)
                            : kNotMeasured;
  link.duplicates = seen["duplicates"];
  link.reordered = seen["reordered"];
  link.delay_p50 = p50(seen) - clear_p50_;
  link.delay_rms = seen["rms_jitter_s"];
  link.delay_spread =
      seen["round_trip_s"]["p90"].get<double>() - seen["round_trip_s"]["p10"].get<double>();
  link.changes = changes;
  if (condition.rate_bit_per_s > 0.0) {
    // One packet at a time, so that none waits for another: the longer ones take longer on the way
    // there only.
    constexpr int kLong = 1200;
    const double slow_hz = std::min(20.0, 0.2 * condition.rate_bit_per_s / (8.0 * kLong));
    const ProbePlan slow{.rate_hz = slow_hz, .seconds = std::max(2.0, 20.0 / slow_hz)};
    const double longer = p50(probe_once(slow, kLong)) - p50(probe_once(slow, kBytes));
    link.rate_set = condition.rate_bit_per_s;
    if (longer > 0.0) link.rate_seen = 8.0 * (kLong - kBytes) / longer;
  }
  spaces_.shape(0, {});
  return link;
}

}  // namespace tandem::harness
