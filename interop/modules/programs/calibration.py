"""camera_calibration without its window: a calibrator, its node, and the checker, on pictures of a chessboard."""

import time
import cv2, numpy, rospy
from camera_calibration.calibrator import CalibrationException, ChessboardInfo, MonoCalibrator
from camera_calibration.camera_calibrator import CalibrationNode
from camera_calibration.camera_checker import CameraCheckerNode
from cv_bridge import CvBridge
from sensor_msgs.msg import CameraInfo, Image
from sensor_msgs.srv import SetCameraInfo, SetCameraInfoResponse


def until(reached, seconds=30):
    end = time.monotonic() + seconds
    while not reached():
        assert time.monotonic() < end, "not in time"
        time.sleep(0.01)


COLS, ROWS, SIDE = 8, 6, 40
K = numpy.array([[500.0, 0, 320], [0, 500, 240], [0, 0, 1]])
board = numpy.full(((ROWS + 3) * SIDE, (COLS + 3) * SIDE), 255, numpy.uint8)
for row in range(ROWS + 1):
    for col in range(COLS + 1):
        if (row + col) % 2 == 0:
            board[(row + 1) * SIDE : (row + 2) * SIDE, (col + 1) * SIDE : (col + 2) * SIDE] = 0


def picture(x, y, z, rx, ry):
    turn, _ = cv2.Rodrigues(numpy.array([rx, ry, 0.1]))
    scale = 0.1 / SIDE
    center = numpy.array(
        [[scale, 0, -0.5 * board.shape[1] * scale], [0, scale, -0.5 * board.shape[0] * scale], [0, 0, 1]]
    )
    view = K @ numpy.column_stack([turn[:, 0], turn[:, 1], [x, y, z]]) @ center
    return cv2.warpPerspective(board, view, (640, 480), borderValue=127)


POSES = [
    (0.3 * (i % 3 - 1), 0.2 * (i % 2), 1.6 + 0.3 * (i % 4), 0.35 * (i % 3 - 1), 0.35 * (i % 5 - 2)) for i in range(14)
]
pictures = [picture(*pose) for pose in POSES]
chessboard = ChessboardInfo(n_cols=COLS, n_rows=ROWS, dim=0.1)
alone = MonoCalibrator([chessboard])
alone.cal(pictures)
print(numpy.round(alone.intrinsics, 3).tolist(), numpy.round(alone.distortion.ravel(), 4).tolist())
print(alone.yaml())
alone.report()
try:
    MonoCalibrator([chessboard]).cal([numpy.zeros((480, 640), numpy.uint8)])
except CalibrationException as error:
    print(type(error).__name__, error)

rospy.init_node("calibration")
bridge = CvBridge()
shown, infos = [], []


class Windowless(CalibrationNode):
    checkerboard_flags = 0

    def redraw_monocular(self, drawable):
        shown.append(drawable)


def take(request):
    infos.append(request.camera_info)
    return SetCameraInfoResponse(True, "taken")


rospy.Service("camera/set_camera_info", SetCameraInfo, take)
node = Windowless([chessboard], True)
image = rospy.Publisher("image", Image, queue_size=1)
until(image.get_num_connections)
for number, each in enumerate(pictures):
    message = bridge.cv2_to_imgmsg(each, "mono8")
    message.header.stamp = rospy.Time(number + 1)
    image.publish(message)
    until(lambda: len(shown) == number + 1)
print(
    [
        (
            type(each).__name__,
            each.scrib.shape,
            None if each.params is None else [(p[0], round(p[1], 3), round(p[2], 3)) for p in each.params],
        )
        for each in shown
    ][::4]
)
print(len(node.c.db), node.c.goodenough)
node.c.do_calibration()
print(node.do_upload(), numpy.round(infos[0].K, 3).tolist(), infos[0].distortion_model, infos[0].width)
image.unregister()


class Listening(CameraCheckerNode):
    def handle_monocular(self, pair):
        super().handle_monocular(pair)
        checked.append(1)


checked = []
checker = Listening((COLS, ROWS), 0.1, 0)
image = rospy.Publisher("monocular/image_rect", Image, queue_size=1)
info = rospy.Publisher("monocular/camera_info", CameraInfo, queue_size=1)
until(lambda: image.get_num_connections() and info.get_num_connections(), 10)
for number, each in enumerate(pictures[:4]):
    message = bridge.cv2_to_imgmsg(each, "mono8")
    message.header.stamp = rospy.Time(number + 1)
    described = infos[0]
    described.header.stamp = message.header.stamp
    image.publish(message)
    info.publish(described)
    until(lambda: len(checked) == number + 1)
