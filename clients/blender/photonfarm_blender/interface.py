"""What the user sees: settings, a panel among the render properties, and the operator that renders."""

import bpy
from bpy.props import EnumProperty, IntProperty, PointerProperty, StringProperty
from photonfarm import Farm, FarmError

from . import rendering

STEP_SECONDS = 1.0
# Blender stands still while it waits for an answer.
PATIENCE = 5.0


class Preferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    url: StringProperty(name="Address", description="Of the coordinator; PHOTONFARM_URL where it is empty")
    token_file: StringProperty(name="Token file", subtype="FILE_PATH", description="PHOTONFARM_TOKEN_FILE or PHOTONFARM_TOKEN where it is empty")
    fingerprint: StringProperty(name="Fingerprint", description="sha256:… of its certificate; PHOTONFARM_FINGERPRINT where it is empty")

    def draw(self, context):
        for name in ("url", "token_file", "fingerprint"):
            self.layout.prop(self, name)


class Settings(bpy.types.PropertyGroup):
    passes: IntProperty(name="Passes", min=1, default=256)
    method: StringProperty(name="Method", description="One of the farm's, or auto; the farm's own choice where it is empty")
    environment: EnumProperty(
        name="Environment",
        items=[
            ("AUTO", "Automatic", "White where the scene has no light of its own"),
            ("ON", "White", "A white environment of radiance 1"),
            ("OFF", "None", "No environment"),
        ],
        description="Blender's world is not exported",
    )


def connect(context) -> Farm:
    """The farm of the preferences, or of the process's environment."""
    addon = context.preferences.addons.get(__package__)
    if addon is None:
        return Farm(patience=PATIENCE)
    chosen = addon.preferences
    token = None
    if chosen.token_file:
        with open(bpy.path.abspath(chosen.token_file)) as file:
            token = file.read().strip()
    return Farm(chosen.url or None, token, fingerprint=chosen.fingerprint or None, patience=PATIENCE)


class PHOTONFARM_OT_render(bpy.types.Operator):
    """Render the scene on a photonfarm, and show the picture while it converges; Esc cancels"""

    bl_idname = "photonfarm.render"
    bl_label = "Render on photonfarm"

    def invoke(self, context, event):
        """Begins, and goes on beside everything else."""
        if not self.begin(context):
            return {"CANCELLED"}
        self.timer = context.window_manager.event_timer_add(STEP_SECONDS, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self.farm_does(self.rendering.job.cancel)
        elif event.type != "TIMER":
            return {"PASS_THROUGH"}
        result = self.step(context, wait=0)
        if result:
            context.window_manager.event_timer_remove(self.timer)
            context.workspace.status_text_set(None)
        return result or {"PASS_THROUGH"}

    def execute(self, context):
        """Without a user, as in scripts: waits for the end."""
        if not self.begin(context):
            return {"CANCELLED"}
        result = None
        while result is None:
            result = self.step(context, wait=round(STEP_SECONDS))
        return result

    def begin(self, context) -> bool:
        """Exports and submits; False when that fails."""
        self.rendering = self.farm_does(lambda: rendering.Rendering(connect(context), context.scene))
        return self.rendering is not None

    def step(self, context, wait):
        """Shows how it is doing; a result when it has ended."""
        status = self.farm_does(lambda: self.rendering.step(wait))
        if status is None:
            return {"CANCELLED"}
        if context.workspace is not None:
            context.workspace.status_text_set(rendering.told(status))
        if status.state not in rendering.FINAL_STATES:
            return None
        self.report({"INFO" if status.state == "done" else "WARNING"}, rendering.told(status))
        return {"FINISHED"} if status.state == "done" else {"CANCELLED"}

    def farm_does(self, work):
        """What the work gives; nothing, and a message to the user, when the farm or the disk refuses."""
        try:
            return work()
        except (FarmError, OSError) as problem:
            # Not as an error: that would be an exception in scripts, without the result.
            self.report({"WARNING"}, str(problem))
            return None


class PHOTONFARM_PT_render(bpy.types.Panel):
    bl_label = "photonfarm"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        for name in ("passes", "method", "environment"):
            layout.prop(context.scene.photonfarm, name)
        layout.operator(PHOTONFARM_OT_render.bl_idname)
        layout.label(text=f"The picture is the image “{rendering.IMAGE_NAME}”.")


CLASSES = (Preferences, Settings, PHOTONFARM_OT_render, PHOTONFARM_PT_render)


def register():
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Scene.photonfarm = PointerProperty(type=Settings)


def unregister():
    del bpy.types.Scene.photonfarm
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
