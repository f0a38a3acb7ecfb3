// SPDX-License-Identifier: Apache-2.0
#include "tools/lcrig/control_client.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <deque>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "base/text.hpp"
#include "tools/lcrig/command_output.hpp"

namespace lcrig::cli {

using nlohmann::json;

namespace {

// How long a daemon may take to accept a connection, or to read what was sent.
constexpr auto kTaking = std::chrono::seconds(15);

Failure unreachable(const std::string& path, const std::string& why) {
  Failure out(kUnreachable, fmt::format("cannot reach the daemon at {}: {}", path, why),
              without_daemon("lcrig rehearse static-frame --specimen paper-1"));
  out.no_daemon = true;
  return out;
}

// Describes a connection that nobody accepts or a message that nobody reads.
std::string errno_words(int error) {
  if (error == EAGAIN || error == EWOULDBLOCK) return "it takes nothing: it hangs, or is stopped";
  return std::strerror(error);
}

bool is_other_file(const std::string& path) {
  std::error_code unknown;
  const auto found = std::filesystem::status(path, unknown);
  return !unknown && std::filesystem::exists(found) && !std::filesystem::is_socket(found);
}

// A daemon may go on without its socket: its run continues, and only signals reach it.
Failure replaced(const std::string& path, int error) {
  Failure out = unreachable(
      path, fmt::format("a file is there that is no socket ({}): the daemon's socket was replaced, "
                        "or --socket names another file; a run in progress goes on",
                        std::strerror(error)));
  out.next = "systemctl restart lcrigd   (makes a new socket, and ends a run: it unloads first)";
  return out;
}

Failure no_access(const std::string& path) {
  return Failure(
      kUnreachable,
      fmt::format("cannot reach the daemon at {}: you are not in the group of the socket", path),
      "sudo adduser $USER lcrig   (then log in again)");
}

// The hint of the daemon. The daemon does not know how it was addressed, so `where` is added to its
// command. An older daemon sends words only.
std::string hint_of(const json& data, const std::string& where) {
  Hint hint;
  hint.command = data.value("command", "");
  if (where.empty() || hint.command.empty()) return data.value("hint", "");
  hint.before = data.value("before", "");
  hint.remark = data.value("remark", "");
  return hint.text(where);
}

// The daemon's message and hint, with the exit code of this program.
Failure failure_of(const json& error, const std::string& where) {
  Failure out;
  out.what = error.value("message", "the daemon refused without a reason");
  out.code = kFailed;
  const auto data = error.find("data");
  if (data == error.end() || !data->is_object()) return out;
  out.next = hint_of(*data, where);
  out.detail = data->value("detail", "");
  const auto word = data->value("errc", "");
  if (const auto errc = parse_word<Errc>(word)) {
    out.code = exit_code_of(*errc);
    out.refused_request = errc == Errc::invalid_request;
    out.busy = errc == Errc::busy;
  }
  return out;
}

Outcome<std::optional<ControlNews>> notification(const std::string& path, const json& message) {
  const auto method = message.value("method", "");
  const json params = message.value("params", json::object());
  const auto wrap = [&](auto parsed) -> Outcome<std::optional<ControlNews>> {
    if (parsed) return ControlNews(std::move(*parsed));
    return unreachable(path, "it speaks another language: " + parsed.error().what);
  };
  if (method == "status") return wrap(parse_run_status(params));
  if (method == "event") return wrap(parse_run_event(params));
  if (method == "run_ended") return wrap(parse_run_outcome(params));
  if (method == "queue") return wrap(parse_queue_status(params));
  return std::optional<ControlNews>();  // a message of a newer daemon
}

}  // namespace

bool is_same_file(const std::string& a, const std::string& b) {
  namespace fs = std::filesystem;
  std::error_code none;
  if (a == b || fs::equivalent(a, b, none)) return true;
  return fs::weakly_canonical(a, none) == fs::weakly_canonical(b, none) && !none;
}

std::string without_daemon(const std::string& rehearsal) {
  return fmt::format("systemctl status lcrigd   (no rig at hand? {})", rehearsal);
}

Failure without_rehearsal(Failure failure) {
  if (failure.no_daemon) failure.next = "systemctl status lcrigd";
  return failure;
}

std::string words_of(const ResumableRun& run) {
  return fmt::format("run {}, {} on {}, in step {}", run.run, printable(run.protocol, kLongestName),
                     printable(run.specimen, kLongestName), printable(run.step_id, kLongestName));
}

struct ControlClient::State {
  State(std::string p, const Clock& c) : path(std::move(p)), clock(c) {}
  ~State() {
    if (fd >= 0) ::close(fd);
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  void bound_sending(Duration patience) const;
  Outcome<std::int64_t> send(std::string_view method, const json& params);
  Outcome<bool> receive();  // what is there now; false: there was nothing
  Outcome<bool> wait(MonoTime end);  // false: time is over
  void say_hint();
  Outcome<json> parse(const std::string& line) const;
  std::optional<json> take_answer(std::int64_t id);

  std::string path;
  std::string where;  // options of the command line that say where
  const Clock& clock;
  Console* console = nullptr;  // shows kStopByHand once, at hint_at
  MonoTime hint_at{};
  int fd = -1;
  int leave_fd = -1;  // when readable, waiting ends; -1: never
  std::int64_t last_id = 0;
  std::string in;
  std::deque<json> backlog;
};

void ControlClient::State::bound_sending(Duration patience) const {
  const auto micros = std::chrono::ceil<std::chrono::microseconds>(patience).count();
  const timeval limit{micros / 1'000'000, micros % 1'000'000};
  ::setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
}

Outcome<std::int64_t> ControlClient::State::send(std::string_view method, const json& params) {
  const auto line = request_line(++last_id, method, params);
  std::string_view rest = line;
  while (!rest.empty()) {
    const auto n = ::send(fd, rest.data(), rest.size(), MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return unreachable(path, errno_words(errno));
    rest.remove_prefix(static_cast<std::size_t>(n));
  }
  return last_id;
}

Outcome<json> ControlClient::State::parse(const std::string& line) const {
  auto message = json::parse(line, nullptr, false);
  if (message.is_object()) return message;
  Failure other = unreachable(path, "it does not speak JSON-RPC; is this lcrigd's socket?");
  other.not_lcrigd = true;
  return other;
}

Outcome<bool> ControlClient::State::receive() {
  std::array<char, 65536> buffer;
  const auto n = ::recv(fd, buffer.data(), buffer.size(), MSG_DONTWAIT);
  if (n < 0 && (errno == EAGAIN || errno == EINTR)) return false;
  if (n < 0) return unreachable(path, std::strerror(errno));
  if (n == 0) return unreachable(path, "it closed the connection");
  in.append(buffer.data(), static_cast<std::size_t>(n));
  for (auto end = in.find('\n'); end != std::string::npos; end = in.find('\n')) {
    auto message = parse(in.substr(0, end));
    in.erase(0, end + 1);
    if (!message) return message.error();
    backlog.push_back(std::move(*message));
  }
  return true;
}

Outcome<bool> ControlClient::State::wait(MonoTime end) {
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - clock.now());
  if (left.count() <= 0) return false;
  std::array<pollfd, 2> wanted{{{fd, POLLIN, 0}, {leave_fd, POLLIN, 0}}};
  const int n = ::poll(wanted.data(), wanted.size(), static_cast<int>(left.count()) + 1);
  if (n < 0 && errno != EINTR) return unreachable(path, std::strerror(errno));
  if (n > 0 && wanted[0].revents == 0) return Failure(kInterrupted, "interrupted", "");
  return true;
}

void ControlClient::State::say_hint() {
  if (console == nullptr || clock.now() < hint_at) return;
  std::exchange(console, nullptr)->note(kStopByHand);
}

std::optional<json> ControlClient::State::take_answer(std::int64_t id) {
  const auto it = std::find_if(backlog.begin(), backlog.end(), [id](const json& message) {
    const auto found = message.find("id");
    if (found == message.end()) return false;
    // null: the daemon refuses the connection itself.
    return *found == id || (found->is_null() && message.contains("error"));
  });
  if (it == backlog.end()) return std::nullopt;
  json message = std::move(*it);
  backlog.erase(it);
  return message;
}

ControlClient::ControlClient(std::unique_ptr<State> state) : state_(std::move(state)) {}
ControlClient::ControlClient(ControlClient&&) noexcept = default;
ControlClient::~ControlClient() = default;

void ControlClient::leave_on(int fd) {
  state_->leave_fd = fd;
}

int ControlClient::fd() const {
  return state_->fd;
}

Outcome<ControlClient> ControlClient::connect(const std::string& path, const Clock& clock,
                                              Duration patience) {
  auto state = std::make_unique<State>(path, clock);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) {
    return Failure(kUsage, fmt::format("--socket {}: the path is too long", path),
                   "a socket path has at most 107 characters");
  }
  path.copy(address.sun_path, path.size());
  state->fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (state->fd < 0) return unreachable(path, std::strerror(errno));
  // Limits `connect`, too, which would wait for a daemon that accepts nobody.
  state->bound_sending(patience);
  if (::connect(state->fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    if (errno == EACCES || errno == EPERM) return no_access(path);
    if (const int error = errno; is_other_file(path)) return replaced(path, error);
    return unreachable(path, errno_words(errno));
  }
  return ControlClient(std::move(state));
}

Outcome<ControlClient> ControlClient::connect(const Context& context) {
  auto client = connect_for_any_database(context);
  if (!client || context.global.db.empty()) return client;
  auto other = client->other_database(context.global.db);
  if (!other) return other.error();
  if (other->empty()) return client;
  return Failure(kUsage, *other, "type it again without --db");
}

Outcome<ControlClient> ControlClient::connect_for_any_database(const Context& context,
                                                               Duration patience) {
  auto path = context.socket_path();
  if (!path) return path.error();
  auto client = connect(*path, context.clock, patience);
  if (client) client->state_->where = given_options(context.global);
  return client;
}

Outcome<ControlClient> ControlClient::connect_to_stop(const Context& context) {
  auto path = context.socket_path();
  if (!path) return path.error();
  const Duration soon = context.env.stop_hint_after;
  const MonoTime hint_at = context.clock.now() + soon;
  const auto prepare = [&](Outcome<ControlClient> client, Console* console) {
    if (!client) return client;
    client->state_->where = given_options(context.global);
    client->state_->console = console;
    client->state_->hint_at = hint_at;
    client->state_->bound_sending(kTaking);
    return client;
  };
  auto client = connect(*path, context.clock, soon);
  const bool hangs = !client && context.clock.now() >= hint_at;
  if (!hangs) return prepare(std::move(client), &context.console);
  context.console.note(kStopByHand);
  const auto left = std::min<Duration>(kTaking, context.env.stop_patience);
  return prepare(connect(*path, context.clock, left), nullptr);
}

void ControlClient::tell_other_database(const Context& context) {
  const auto named = context.named_db();
  const bool typed = !context.global.db.empty();
  if (!named || !*named || (!typed && !context.global.config.empty())) return;
  const auto other = other_database(**named, typed ? "--db" : "$LCRIG_DB");
  if (other && !other->empty()) context.console.note(*other);
}

Outcome<std::string> ControlClient::database(Duration patience) {
  auto status = call("status", json::object(), patience);
  if (!status) return status.error();
  const auto parsed = parse_daemon_status(*status);
  if (!parsed) return Failure(parsed.error());
  if (std::filesystem::path(parsed->database).is_absolute()) return parsed->database;
  return Failure(kFailed,
                 fmt::format("the daemon at {} does not say which database it has", state_->path),
                 "");
}

Outcome<std::string> ControlClient::other_database(const std::string& named, const char* named_by) {
  auto theirs = database();
  if (!theirs) return theirs.error();
  if (is_same_file(named, *theirs)) return std::string();
  return fmt::format("{} {}: the daemon at {} has another database, {}", named_by, named,
                     state_->path, *theirs);
}

Outcome<json> ControlClient::call(std::string_view method, const json& params, Duration timeout) {
  const MonoTime end = state_->clock.now() + timeout;
  auto id = state_->send(method, params);
  // A daemon that refuses the connection says why before it closes.
  for (;;) {
    if (auto answer = state_->take_answer(id.value_or(0))) {
      if (const auto error = answer->find("error"); error != answer->end()) {
        return failure_of(*error, state_->where);
      }
      return answer->value("result", json());
    }
    auto got = state_->receive();
    if (!got) return id ? got.error() : id.error();
    if (*got) continue;
    const bool hints = state_->console != nullptr && state_->hint_at < end;
    auto in_time = state_->wait(hints ? state_->hint_at : end);
    if (!in_time) return in_time.error();
    state_->say_hint();
    if (!*in_time && !hints) {
      // The daemon is there, so do not propose to do without one.
      Failure silent = unreachable(
          state_->path, fmt::format("{}: no answer in {:.6g} s", method, to_seconds(timeout)));
      silent.next = "systemctl status lcrigd";
      return silent;
    }
  }
}

Outcome<std::int64_t> ControlClient::post(std::string_view method, const json& params) {
  return state_->send(method, params);
}

Outcome<std::optional<ControlNews>> ControlClient::take() {
  if (state_->backlog.empty()) {
    auto got = state_->receive();
    if (!got) return got.error();
    if (state_->backlog.empty()) return std::optional<ControlNews>();
  }
  const json message = std::move(state_->backlog.front());
  state_->backlog.pop_front();
  if (message.contains("method")) return notification(state_->path, message);
  ControlAnswer answer;
  const auto id = message.find("id");
  if (id != message.end() && id->is_number_integer()) answer.id = id->get<std::int64_t>();
  if (const auto error = message.find("error"); error != message.end()) {
    answer.failure = failure_of(*error, state_->where);
  }
  return ControlNews(std::move(answer));
}

Outcome<json> call_daemon(const Context& context, std::string_view method, const json& params,
                          Duration timeout) {
  auto client = ControlClient::connect(context);
  if (!client) return client.error();
  return client->call(method, params, timeout);
}

}  // namespace lcrig::cli
