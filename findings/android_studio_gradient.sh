#!/bin/bash
# A VectorDrawable whose gradient has no white space around it: Android Studio's preview draws nothing.
#
# `aapt:attr` and `gradient` are elements, and white space between elements means nothing in XML; Android's own reader
# takes both forms. The previewer of Android Studio (sdk-common 30.0.0, class VdPreview, in the npm package vd-tool
# 4.0.2) fills the path only if there is a line end between each pair of tags.
# Seen: 1 colour without line ends, 100 or more with them.
# Needs npm and a JDK.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund vd-tool@4.0.2 >/dev/null
cat > Colors.java <<'JAVA'
import com.android.ide.common.vectordrawable.VdPreview;
import java.awt.image.BufferedImage;
import java.nio.file.*;
import java.util.*;

public class Colors {
    public static void main(String[] names) throws Exception {
        for (String name : names) {
            String text = new String(Files.readAllBytes(Paths.get(name)));
            BufferedImage image = VdPreview.getPreviewFromVectorXml(
                VdPreview.TargetSize.createFromMaxDimension(128), text, new StringBuilder());
            Set<Integer> colors = new HashSet<>();
            for (int y = 0; y < 128; y++) for (int x = 0; x < 128; x++) colors.add(image.getRGB(x, y));
            System.out.println(name + " " + colors.size());
        }
    }
}
JAVA
cat > spaced.xml <<'XML'
<vector xmlns:android="http://schemas.android.com/apk/res/android" xmlns:aapt="http://schemas.android.com/aapt" android:width="256dp" android:height="256dp" android:viewportWidth="256" android:viewportHeight="256"><path android:pathData="M10 10h200v200h-200z">
<aapt:attr name="android:fillColor">
<gradient android:type="linear" android:startX="20" android:startY="20" android:endX="120" android:endY="60"><item android:offset="0" android:color="#ffcc2222"/><item android:offset="1" android:color="#ff663399"/></gradient>
</aapt:attr>
</path></vector>
XML
tr -d '\n' < spaced.xml > compact.xml
found=$(java -cp 'node_modules/vd-tool/lib/*' Colors.java compact.xml spaced.xml)
echo "$found"
compact=$(echo "$found" | sed -n 's/^compact.xml //p')
spaced=$(echo "$found" | sed -n 's/^spaced.xml //p')
[ "$compact" = 1 ] && [ "$spaced" -ge 100 ]
