#include "tests/view/x_server.h"

#include <cmath>
#include <csignal>
#include <cstdlib>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace tandem::test {

XServer::XServer(const std::string& size) {
  int ends[2];
  if (pipe(ends) != 0) return;
  const std::string screen = size + "x24", fd = std::to_string(ends[1]);
  pid_ = fork();
  if (pid_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    close(ends[0]);
    if (std::freopen("/dev/null", "w", stderr) == nullptr) _exit(1);
    execlp("Xvfb", "Xvfb", "-displayfd", fd.c_str(), "-screen", "0", screen.c_str(), "-nolisten",
           "tcp", "-noreset", static_cast<char*>(nullptr));
    _exit(127);
  }
  close(ends[1]);
  // Its number, when it is ready, and a line's end in a write of its own: a pipe closed between the
  // two ends Xvfb.
  std::string text;
  char c = '\0';
  pollfd ready{ends[0], POLLIN, 0};
  while (poll(&ready, 1, 20'000) == 1 && read(ends[0], &c, 1) == 1 && c != '\n') text += c;
  if (c == '\n') display_ = ":" + text;
  close(ends[0]);
}

XServer::~XServer() { kill(); }

void XServer::kill() {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGTERM);
  waitpid(pid_, nullptr, 0);
  pid_ = -1;
}

void XServer::use() const { setenv("DISPLAY", display_.c_str(), 1); }

Thing thing_at(const view::Image& image, double x, double y) {
  const int px = static_cast<int>(std::lround(x - 0.5)),
            py = static_cast<int>(std::lround(y - 0.5));
  if (px < 0 || py < 0 || px >= image.width || py >= image.height) return Thing::kOther;
  const unsigned char* c =
      &image.rgb[3 * (static_cast<std::size_t>(py) * static_cast<std::size_t>(image.width) +
                      static_cast<std::size_t>(px))];
  const double r = c[0], g = c[1], b = c[2], sum = r + g + b + 1.0;
  const double red = r / sum, blue = b / sum;
  // Shares of red and blue: box .43 .22, user 1 .00 .65, user 2 .68 .04, ground and wall .33 .34
  // before light; light moves them by a few hundredths.
  if (blue > 0.45) return Thing::kUser1;
  if (red > 0.52) return Thing::kUser2;
  if (red > 0.38 && blue < 0.28) return Thing::kBox;
  if (std::abs(red - 1.0 / 3) < 0.06) return sum / 765.0 > 0.68 ? Thing::kGround : Thing::kWall;
  return Thing::kOther;
}

}  // namespace tandem::test
