// The available displays, by their keys. A key is a topic; or a kind of display and the topic, "camera:/camera/image"; or
// "robot:" and the parameter with a robot's URDF.
// Pure.

// Supported types, and rviz's names of their displays.
export const DISPLAY_TYPES = {
  __proto__: null, // a robot may send a type named "constructor"
  "geometry_msgs/AccelStamped": "AccelStamped",
  "geometry_msgs/PointStamped": "PointStamped",
  "geometry_msgs/PolygonStamped": "Polygon",
  "geometry_msgs/PoseArray": "PoseArray",
  "geometry_msgs/PoseStamped": "Pose",
  "geometry_msgs/PoseWithCovarianceStamped": "PoseWithCovariance",
  "geometry_msgs/TwistStamped": "TwistStamped",
  "geometry_msgs/WrenchStamped": "WrenchStamped",
  "nav_msgs/GridCells": "GridCells",
  "nav_msgs/OccupancyGrid": "Map",
  "nav_msgs/Odometry": "Odometry",
  "nav_msgs/Path": "Path",
  "sensor_msgs/CompressedImage": "Image",
  "sensor_msgs/FluidPressure": "FluidPressure",
  "sensor_msgs/Illuminance": "Illuminance",
  "sensor_msgs/Image": "Image",
  "sensor_msgs/Imu": "Imu",
  "sensor_msgs/JointState": "Effort",
  "sensor_msgs/LaserScan": "LaserScan",
  "sensor_msgs/PointCloud": "PointCloud",
  "sensor_msgs/PointCloud2": "PointCloud2",
  "sensor_msgs/Range": "Range",
  "sensor_msgs/RelativeHumidity": "RelativeHumidity",
  "sensor_msgs/Temperature": "Temperature",
  "visualization_msgs/InteractiveMarkerUpdate": "InteractiveMarkers",
  "visualization_msgs/Marker": "Marker",
  "visualization_msgs/MarkerArray": "MarkerArray",
};

export const ROBOT_PREFIX = "robot:";
export const ROBOT_DESCRIPTION = "/robot_description";
const IMAGE_TYPES = ["sensor_msgs/Image", "sensor_msgs/CompressedImage"];
const CAMERA_INFO = "sensor_msgs/CameraInfo";
const KEY_PREFIXES = { camera: "Camera", depth: "DepthCloud" }; // displays of image topics
const VIEWS = { Camera: "scene_camera", DepthCloud: "scene_depth", Image: "image", InteractiveMarkers: "scene_interactive" };

// Return {topic, kind, view} of a key: rviz's name of its display ("" if the topic has no publishers yet), and the
// server's view for it. types: topic -> type.
export function parseKey(key, types) {
  const made = /^(camera|depth):/.exec(key)?.[1];
  const topic = made ? key.slice(made.length + 1) : key;
  const type = types[topic];
  const kind = made ? (IMAGE_TYPES.includes(type) ? KEY_PREFIXES[made] : "") : DISPLAY_TYPES[type] || "";
  return { topic, kind, view: VIEWS[kind] || "scene_topic" };
}

// Return what can be added to the displayed topics and robots: [{key, title, kind, text, field}].
export function addableDisplays(types, topics, robots) {
  const keys = [];
  for (const topic of Object.keys(types).sort()) {
    if (DISPLAY_TYPES[types[topic]]) keys.push(topic);
    if (!IMAGE_TYPES.includes(types[topic]) || types[infoTopic(topic, types[topic])] !== CAMERA_INFO) continue;
    keys.push(`camera:${topic}`);
    if (/depth/i.test(topic)) keys.push(`depth:${topic}`);
  }
  /** @type {{key: string, title: string, kind: string, text: string, field?: boolean}[]} */
  const offers = keys.filter((key) => !topics.includes(key)).map((key) => {
    const { topic, kind } = parseKey(key, types);
    return { key, title: topic, kind, text: `${topic}: ${types[topic]}` };
  });
  if (!robots.includes(ROBOT_DESCRIPTION)) offers.unshift({ key: ROBOT_PREFIX + ROBOT_DESCRIPTION, title: ROBOT_DESCRIPTION, kind: "RobotModel", text: "the robot as its URDF describes it" });
  if (Object.values(types).includes(CAMERA_INFO)) offers.push({ key: "depth:", title: "/depth/image", kind: "DepthCloud", text: "the topic with other depths", field: true });
  return [...offers, { key: ROBOT_PREFIX, title: "/other_robot", kind: "RobotModel", text: "the parameter with another robot's URDF", field: true }];
}

export function imageTopics(types) {
  return Object.keys(types).filter((topic) => IMAGE_TYPES.includes(types[topic])).sort();
}

// Return the topic of an image topic's CameraInfo; same as pyros1/web/scene/camera.py.
export function infoTopic(topic, type) {
  const base = type === "sensor_msgs/CompressedImage" ? topic.replace(/\/[^/]*$/, "") : topic;
  return `${base.slice(0, Math.max(0, base.lastIndexOf("/")))}/camera_info`;
}
