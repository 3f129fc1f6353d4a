#include "cli/beside_window.h"

#include <atomic>
#include <cstdio>
#include <exception>
#include <memory>
#include <thread>
#include <unistd.h>

#include <fmt/format.h>

#include "cli/commands.h"
#include "cli/view.h"
#include "devices/pointer_feed.h"
#include "view/assemble.h"
#include "view/gl_window.h"
#include "view/other_hands.h"
#include "view/viewer.h"

namespace tandem::cli {

namespace {

/// The node's thread and how it ended.
class NodeThread {
 public:
  NodeThread(const WindowedNode& node, const node::NodeOptions& options)
      : thread_([this, &node, options] {
          try {
            report_ = node.run(options);
          } catch (...) {
            error_ = std::current_exception();
          }
          ended_ = true;
        }) {}
  ~NodeThread() { wait(); }
  NodeThread(const NodeThread&) = delete;
  NodeThread& operator=(const NodeThread&) = delete;

  [[nodiscard]] const std::atomic<bool>& ended() const { return ended_; }
  void wait() {
    if (thread_.joinable()) thread_.join();
  }
  /// After `wait`. Throws what the node threw.
  [[nodiscard]] const node::NodeReport& report() const {
    if (error_) std::rethrow_exception(error_);
    return report_;
  }

 private:
  node::NodeReport report_;
  std::exception_ptr error_;
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

}  // namespace

void run_node(const WindowedNode& node, node::NodeOptions options, const NodeArguments& a) {
  devices::PointerFeed feed;
  if (a.hands == "pointer") {
    if (!a.view)
      throw CLI::ValidationError("--hands pointer", "needs a window to point in: give --view too");
    if (!view::has_display())
      throw CLI::ValidationError("--hands pointer",
                                 "needs a display to point on, and DISPLAY is not set");
    if (core::index_of(node.scene.users, node.pointer) < 0)
      throw CLI::ValidationError("--hands pointer",
                                 "no user sits at a server without local users; "
                                 "point at a client or a replica");
    options.hands.pointer = &feed;
  }
  if (!a.view) return finish(node.run(options), a.json);

  core::ViewTap tap(node.scene.most_ticks_per_packet());
  options.window = &tap;
  WindowArguments window = a.window_arguments();
  view::ViewerOptions v = window.options();
  v.seconds = 0.0;  // the node says when it is over
  v.text.title = node.scene.name + ", " + (node.user == "server" ? "server" : "user " + node.user);
  v.text.legend = legend_of(node.scene, options.hands.pointer != nullptr);
  v.text.margin = margin_of(node.scene, 0.0);
  if (options.hands.pointer != nullptr) {
    v.pointer = &feed;
    v.pointer_user = core::index_of(node.scene.users, node.pointer);
  }

  view::Assembler assembler(node.scene, node.user);
  NodeThread thread(node, options);
  v.stop = &thread.ended();
  const auto end = [&](const nlohmann::ordered_json& seen) {
    thread.wait();
    finish(thread.report(), a.json, seen);
  };
  // The X server is gone: Xlib would end this program here and now. The node first comes to its
  // end, and then this program, without another word to the display.
  v.on_display_lost = [&] {
    std::fputs("window: the display is gone; the node goes on without a window\n", stderr);
    int status = 0;
    try {
      end({{"ended", "the display is gone"}});
    } catch (const std::exception& e) {
      std::fprintf(stderr, "%s\n", e.what());
      status = 1;
    }
    std::fflush(nullptr);
    _exit(status);
  };
  std::unique_ptr<view::OtherHands> others;
  if (!node.server.empty())
    others = std::make_unique<view::OtherHands>(node.server, version_text());
  const int own_user = core::index_of(node.scene.users, node.user);
  view::Source source;
  source.newest = [&](view::Snapshot& out) {
    const bool any = view::take_all(tap, assembler);
    if (any) out = assembler.snapshot();
    if (any && others) (void)others->add_to(out, own_user);
    return any;
  };
  nlohmann::ordered_json seen;
  try {
    const view::ViewerReport report = view::run_viewer(node.scene, source, v);
    seen = to_json(node.scene, report);
    if (!thread.ended())
      std::fprintf(stderr, "window: %s; the node goes on without it (Ctrl-C ends it)\n",
                   report.ended.c_str());
  } catch (const std::exception& e) {
    seen = {{"ended", e.what()}};
    std::fprintf(stderr, "window: %s\nwindow: the node goes on without it\n", e.what());
  }
  end(seen);
}

}  // namespace tandem::cli
