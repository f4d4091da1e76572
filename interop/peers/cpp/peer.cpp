// The roscpp peer of the interop tests: does what the lines on its standard input say and prints one line per event.
// interop/README.md lists the commands; rospy_peer.py and pyros1_peer.py take the same ones.
#include <poll.h>
#include <ros/ros.h>
#include <unistd.h>

#include <boost/crc.hpp>
#include <clocale>
#include <cstdio>
#include <map>
#include <memory>
#include <mutex>
#include <sstream>

#include "samples.hpp"

static const double kDeadline = 10.0;  // seconds, for the commands that wait

static void say(const std::string& line) {
  static std::mutex mutex;
  std::lock_guard<std::mutex> lock(mutex);
  std::fwrite((line + "\n").data(), 1, line.size() + 1, stdout);
  std::fflush(stdout);
}

template <class M> std::string body(const M& message) {
  std::vector<uint8_t> raw(ros::serialization::serializationLength(message));
  ros::serialization::OStream stream(raw.data(), raw.size());
  ros::serialization::serialize(stream, message);
  char buffer[32];
  if (raw.size() > 4096) {
    boost::crc_32_type crc;
    crc.process_bytes(raw.data(), raw.size());
    std::snprintf(buffer, sizeof buffer, "#%zu:%08x", raw.size(), static_cast<unsigned>(crc.checksum()));
    return buffer;
  }
  std::string out = raw.empty() ? "-" : "";
  for (uint8_t byte : raw) {
    std::snprintf(buffer, sizeof buffer, "%02x", byte);
    out += buffer;
  }
  return out;
}

static std::string json(const std::string& text) {
  std::string out = "\"";
  for (char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

static std::string json(XmlRpc::XmlRpcValue& value) {
  char buffer[64];
  std::string out;
  switch (value.getType()) {
    case XmlRpc::XmlRpcValue::TypeBoolean: return static_cast<bool&>(value) ? "true" : "false";
    case XmlRpc::XmlRpcValue::TypeInt: return std::to_string(static_cast<int&>(value));
    case XmlRpc::XmlRpcValue::TypeDouble:
      std::snprintf(buffer, sizeof buffer, "%.17g", static_cast<double&>(value));
      out = buffer;
      return out.find_first_of(".en") == std::string::npos ? out + ".0" : out;
    case XmlRpc::XmlRpcValue::TypeString: return json(static_cast<std::string&>(value));
    case XmlRpc::XmlRpcValue::TypeBase64:
      for (char c : static_cast<XmlRpc::XmlRpcValue::BinaryData&>(value)) {
        std::snprintf(buffer, sizeof buffer, "%02x", static_cast<unsigned char>(c));
        out += buffer;
      }
      return "<" + out + ">";
    case XmlRpc::XmlRpcValue::TypeArray:
      for (int i = 0; i < value.size(); ++i) out += (i ? ", " : "") + json(value[i]);
      return "[" + out + "]";
    case XmlRpc::XmlRpcValue::TypeStruct:
      for (auto& item : value) out += (out.empty() ? "" : ", ") + json(item.first) + ": " + json(item.second);
      return "{" + out + "}";
    default: return "invalid";
  }
}

static XmlRpc::XmlRpcValue parameter(const std::string& name) {
  XmlRpc::XmlRpcValue value;
  if (name == "int") value = 42;
  else if (name == "negative") value = -2147483647;
  else if (name == "float") value = 0.1;
  else if (name == "whole") value = 3.0;
  else if (name == "true") value = true;
  else if (name == "false") value = false;
  else if (name == "text") value = samples::text(1) + " <&>";
  else if (name == "empty") value = "";
  else if (name == "list") {
    value[0] = 1;
    value[1] = "two";
    value[2] = 3.5;
    value[3][0] = true;
  } else if (name == "dict") {
    value["a"] = 1;
    value["b"]["c"] = samples::text(2);
    value["b"]["d"][0] = 0.25;
  } else if (name == "binary") {
    char raw[] = {0, 1, static_cast<char>(0xff), 10};
    value = XmlRpc::XmlRpcValue(raw, sizeof raw);
  } else throw std::runtime_error("no parameter sample " + name);
  return value;
}

struct Publication {
  virtual ~Publication() = default;
  ros::Publisher publisher;
  virtual std::string send(long seed) = 0;
};
struct Subscription {
  virtual ~Subscription() = default;
  ros::Subscriber subscriber;
  std::mutex mutex;
  ros::M_string header;
};
struct Server {
  virtual ~Server() = default;
  ros::ServiceServer server;
};
struct Client {
  virtual ~Client() = default;
  virtual void call(const std::string& name, long seed) = 0;
};

template <class M> struct TypedPublication : Publication {
  std::string send(long seed) override {
    M message;
    samples::fill(message, seed);
    publisher.publish(message);
    return body(message);
  }
};

template <class M> struct TypedSubscription : Subscription {
  std::string topic;
  void heard(const ros::MessageEvent<M const>& event) {
    {
      std::lock_guard<std::mutex> lock(mutex);
      header = event.getConnectionHeader();
    }
    say("got " + topic + " " + body(*event.getMessage()));
  }
};

template <class S> struct TypedServer : Server {
  std::string name, mode;
  bool handle(typename S::Request& request, typename S::Response& response) {
    say("served " + name + " " + body(request));
    if (mode == "refuse") return false;
    if (mode == "throw") throw std::runtime_error("no luck");
    if (mode == "die") _exit(9);
    samples::reply(request, response);
    return true;
  }
};

template <class S> struct TypedClient : Client {
  ros::ServiceClient client;
  void call(const std::string& name, long seed) override {
    S exchange;
    samples::fill(exchange.request, seed);
    say("called " + name + " " + body(exchange.request));
    say(client.call(exchange) ? "answer " + name + " " + body(exchange.response) : "failed " + name);
  }
};

struct MessageType {
  virtual ~MessageType() = default;
  virtual std::unique_ptr<Publication> advertise(ros::NodeHandle& node, const std::string& topic, int queue, bool latch) = 0;
  virtual std::unique_ptr<Subscription> subscribe(ros::NodeHandle& node, const std::string& topic, int queue) = 0;
  virtual std::string sample(long seed) = 0;
};
template <class M> struct TypedMessage : MessageType {
  std::unique_ptr<Publication> advertise(ros::NodeHandle& node, const std::string& topic, int queue, bool latch) override {
    auto out = std::make_unique<TypedPublication<M>>();
    out->publisher = node.advertise<M>(topic, queue, latch);
    return out;
  }
  std::unique_ptr<Subscription> subscribe(ros::NodeHandle& node, const std::string& topic, int queue) override {
    auto out = std::make_unique<TypedSubscription<M>>();
    out->topic = topic;
    out->subscriber = node.subscribe(topic, queue, &TypedSubscription<M>::heard, out.get(),
                                     ros::TransportHints().tcpNoDelay());
    return out;
  }
  std::string sample(long seed) override {
    M message;
    samples::fill(message, seed);
    return body(message);
  }
};

struct ServiceType {
  virtual ~ServiceType() = default;
  virtual std::unique_ptr<Server> serve(ros::NodeHandle& node, const std::string& name, const std::string& mode) = 0;
  virtual std::unique_ptr<Client> client(ros::NodeHandle& node, const std::string& name, bool persistent) = 0;
};
template <class S> struct TypedService : ServiceType {
  std::unique_ptr<Server> serve(ros::NodeHandle& node, const std::string& name, const std::string& mode) override {
    auto out = std::make_unique<TypedServer<S>>();
    out->name = name;
    out->mode = mode;
    out->server = node.advertiseService(name, &TypedServer<S>::handle, out.get());
    return out;
  }
  std::unique_ptr<Client> client(ros::NodeHandle& node, const std::string& name, bool persistent) override {
    auto out = std::make_unique<TypedClient<S>>();
    out->client = node.serviceClient<S>(name, persistent);
    return out;
  }
};

template <class... M> std::map<std::string, std::unique_ptr<MessageType>> messageTypes() {
  std::map<std::string, std::unique_ptr<MessageType>> out;
  ((out[ros::message_traits::datatype<M>()] = std::make_unique<TypedMessage<M>>()), ...);
  return out;
}
template <class... S> std::map<std::string, std::unique_ptr<ServiceType>> serviceTypes() {
  std::map<std::string, std::unique_ptr<ServiceType>> out;
  ((out[ros::service_traits::datatype<S>()] = std::make_unique<TypedService<S>>()), ...);
  return out;
}

class Peer {
 public:
  bool command(const std::string& line) {
    std::istringstream words(line);
    std::string verb, name, type, mode;
    words >> verb >> name;
    long seed = 0;
    int queue = 0, flag = 0, number = 0;
    if (verb == "pub") {
      words >> type >> queue >> flag;
      publications_[name] = messages_.at(type)->advertise(node_, name, queue, flag);
      say("advertised " + name);
    } else if (verb == "send") {
      words >> seed;
      say("sent " + name + " " + publications_.at(name)->send(seed));
    } else if (verb == "burst") {
      words >> seed >> number;
      for (int i = 0; i < number; ++i) publications_.at(name)->send(seed + i);
      say("burst " + name);
    } else if (verb == "unpub") {
      publications_.erase(name);
      say("unadvertised " + name);
    } else if (verb == "sub") {
      words >> type >> queue;
      subscriptions_[name] = messages_.at(type)->subscribe(node_, name, queue);
      say("subscribed " + name);
    } else if (verb == "unsub") {
      subscriptions_.at(name)->subscriber.shutdown();
      say("unsubscribed " + name);
    } else if (verb == "linked") {
      words >> number;
      wait("linked " + name + " " + std::to_string(number), [&] { return links(name) == number; });
    } else if (verb == "header") {
      Subscription& subscription = *subscriptions_.at(name);
      std::lock_guard<std::mutex> lock(subscription.mutex);
      std::string out;
      for (auto& field : subscription.header) {
        boost::crc_32_type crc;
        crc.process_bytes(field.second.data(), field.second.size());
        char definition[16];
        std::snprintf(definition, sizeof definition, "%08x", static_cast<unsigned>(crc.checksum()));
        out += " " + field.first + "=" + (field.first == "message_definition" ? definition : field.second);
      }
      say("header " + name + out);
    } else if (verb == "serve") {
      words >> type >> mode;
      servers_[name] = services_.at(type)->serve(node_, name, mode);
      say("serving " + name);
    } else if (verb == "unserve") {
      servers_.at(name)->server.shutdown();
      servers_.erase(name);
      say("unserved " + name);
    } else if (verb == "available") {
      wait("available " + name, [&] { return ros::service::exists(name, false); });
    } else if (verb == "call") {
      words >> type >> seed >> flag;
      auto& kept = clients_[name];
      if (!flag) services_.at(type)->client(node_, name, false)->call(name, seed);
      else {
        if (!kept) kept = services_.at(type)->client(node_, name, true);
        kept->call(name, seed);
      }
    } else if (verb == "hangup") {
      clients_.erase(name);
      say("hung " + name);
    } else if (verb == "setparam") {
      words >> type;
      node_.setParam(name, parameter(type));
      say("set " + name);
    } else if (verb == "getparam" || verb == "cachedparam") {
      XmlRpc::XmlRpcValue value;
      bool found = verb == "getparam" ? node_.getParam(name, value) : node_.getParamCached(name, value);
      say(verb + " " + name + " " + (found ? json(value) : "unset"));
    } else if (verb == "hasparam") {
      say("hasparam " + name + (node_.hasParam(name) ? " 1" : " 0"));
    } else if (verb == "delparam") {
      say("delparam " + name + (node_.deleteParam(name) ? " 1" : " 0"));
    } else if (verb == "searchparam") {
      std::string found;
      say("searchparam " + name + " " + (ros::param::search(name, found) ? found : "none"));
    } else if (verb == "log") {
      std::string text;
      std::getline(words >> std::ws, text);
      if (name == "debug") ROS_DEBUG("%s", text.c_str());
      else if (name == "info") ROS_INFO("%s", text.c_str());
      else if (name == "warn") ROS_WARN("%s", text.c_str());
      else if (name == "error") ROS_ERROR("%s", text.c_str());
      else ROS_FATAL("%s", text.c_str());
      say("logged " + name);
    } else if (verb == "sample") {
      words >> seed;
      say("sample " + name + " " + messages_.at(name)->sample(seed));
    } else if (verb == "types") {
      std::string out;
      for (auto& entry : messages_) out += " " + entry.first;
      say("types" + out);
    } else {
      if (verb != "quit") throw std::runtime_error("unknown command");
      return false;
    }
    return true;
  }

 private:
  int links(const std::string& name) {
    auto publication = publications_.find(name);
    if (publication != publications_.end()) return publication->second->publisher.getNumSubscribers();
    return subscriptions_.at(name)->subscriber.getNumPublishers();
  }

  template <class Condition> void wait(const std::string& what, Condition reached) {
    const ros::WallTime end = ros::WallTime::now() + ros::WallDuration(kDeadline);
    while (ros::ok() && !reached()) {
      if (ros::WallTime::now() > end) return say("timeout " + what);
      ros::WallDuration(0.005).sleep();
    }
    say(what);
  }

  ros::NodeHandle node_;
  std::map<std::string, std::unique_ptr<MessageType>> messages_ =
      messageTypes<std_msgs::Empty, std_msgs::Bool, std_msgs::Int8, std_msgs::Int64, std_msgs::UInt64, std_msgs::Float32,
                   std_msgs::Float64, std_msgs::Time, std_msgs::Duration, std_msgs::String, std_msgs::Header,
                   std_msgs::ByteMultiArray, std_msgs::UInt8MultiArray, std_msgs::Int32MultiArray,
                   sensor_msgs::JointState, sensor_msgs::Imu, sensor_msgs::CameraInfo, sensor_msgs::LaserScan,
                   sensor_msgs::PointCloud2, sensor_msgs::Image, nav_msgs::Odometry, tf2_msgs::TFMessage,
                   diagnostic_msgs::DiagnosticArray, visualization_msgs::Marker, trajectory_msgs::JointTrajectory,
                   rosgraph_msgs::Log, rosgraph_msgs::TopicStatistics>();
  std::map<std::string, std::unique_ptr<ServiceType>> services_ =
      serviceTypes<std_srvs::Empty, std_srvs::Trigger, std_srvs::SetBool, nav_msgs::GetPlan>();
  std::map<std::string, std::unique_ptr<Publication>> publications_;
  std::map<std::string, std::unique_ptr<Subscription>> subscriptions_;
  std::map<std::string, std::unique_ptr<Server>> servers_;
  std::map<std::string, std::unique_ptr<Client>> clients_;
};

int main(int argc, char** argv) {
  std::setlocale(LC_CTYPE, "");  // or log4cxx turns all but ASCII into question marks
  ros::init(argc, argv, argc > 1 ? argv[1] : "roscpp_peer");
  Peer peer;
  ros::AsyncSpinner spinner(2);
  spinner.start();
  say("ready " + ros::this_node::getName());
  std::string pending;
  bool more = true;
  while (more && ros::ok()) {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (poll(&input, 1, 50) <= 0) continue;
    char buffer[4096];
    ssize_t got = read(STDIN_FILENO, buffer, sizeof buffer);
    if (got <= 0) break;
    pending.append(buffer, got);
    for (size_t end; more && (end = pending.find('\n')) != std::string::npos;) {
      std::string line = pending.substr(0, end);
      pending.erase(0, end + 1);
      try {
        more = peer.command(line);
      } catch (const std::exception& problem) {
        say("error " + line + ": " + problem.what());
      }
    }
  }
  spinner.stop();
  say("bye");
  return 0;
}
